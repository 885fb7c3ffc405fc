// Headless Chromium for tests of pages.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "temporary_folder.h"

namespace lake {

class Browser {
 public:
  // The program's name; empty if none is installed.
  static std::string Find() {
    for (const char* name : {"chromium", "chromium-headless-shell", "google-chrome"})
      if (std::system(fmt::format("command -v {} >/dev/null 2>&1", name).c_str()) == 0) return name;
    return {};
  }

  // The reader's theme from here on.
  void PreferDark() { theme_ = "--blink-settings=preferredColorScheme=0"; }

  // What became of a page: its document as the scripts left it, and what they said on the console.
  struct Visit {
    std::string document, console;
  };

  // Opens the page at a width, waits until nothing moves any more.
  Visit Open(const std::string& html, int width_px = 1280) {
    const std::string output =
        Run(html, fmt::format("--virtual-time-budget=5000 --window-size={},900 --dump-dom", width_px));
    return {output, Console()};
  }

  // Opens the page with `script` behind it, an async function's body that returns a value.
  Json Ask(const std::string& html, const std::string& script, int width_px = 1280) {
    const std::string probe =
        "<script>(async () => {" + script +
        "})().catch(e => 'error: ' + e.stack).then(answer => {const out = document.createElement('output');"
        "out.id = 'answer'; out.textContent = encodeURIComponent(JSON.stringify(answer)); document.body.append(out);});"
        "</script></body>";
    std::string page = html;
    // Chromium that only waits for a document draws no frames.
    const std::string head = "<head>\n";
    page.insert(
        page.find(head) + head.size(),
        "<script>window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 0);</script>");
    page.replace(page.rfind("</body>"), std::string("</body>").size(), probe);
    const std::string document = Open(page, width_px).document;
    const std::string begin = "<output id=\"answer\">";
    const std::size_t at = document.find(begin);
    if (at == document.npos) throw std::runtime_error("the page gave no answer; console: " + Console());
    const std::size_t from = at + begin.size();
    return Json::parse(DecodedUri(document.substr(from, document.find('<', from) - from)));
  }

  // A picture of the page's top.
  std::filesystem::path Screenshot(const std::string& html, int width_px, int height_px) {
    const std::filesystem::path png = folder_ / "page.png";
    Run(html, fmt::format("--hide-scrollbars --force-device-scale-factor=1 --window-size={},{} --screenshot={}",
                          width_px, height_px, png.string()));
    return png;
  }

  std::filesystem::path Print(const std::string& html) {
    const std::filesystem::path pdf = folder_ / "page.pdf";
    Run(html, fmt::format("--virtual-time-budget=5000 --no-pdf-header-footer --print-to-pdf={}", pdf.string()));
    return pdf;
  }

 private:
  static std::string DecodedUri(const std::string& text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool code = text[i] == '%';
      decoded += code ? static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16)) : text[i];
      if (code) i += 2;
    }
    return decoded;
  }

  // Without sandbox, as tests may run as root in a container, where Chromium refuses to make one.
  std::string Run(const std::string& html, const std::string& arguments) {
    const std::filesystem::path page = folder_ / "page.html";
    WriteTextFile(page, html);
    const std::string command = fmt::format(
        "timeout 120 {0} --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run "
        "--user-data-dir={1}/profile --enable-logging=stderr {4} {2} file://{3} >{1}/stdout 2>{1}/stderr",
        Find(), folder_.Path().string(), arguments, page.string(), theme_);
    const int status = std::system(command.c_str());
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
      throw std::runtime_error("the browser failed: " + ReadTextFile(folder_ / "stderr"));
    return ReadTextFile(folder_ / "stdout");
  }

  // The lines of the log that come from pages.
  std::string Console() const {
    std::string lines;
    std::istringstream log(ReadTextFile(folder_ / "stderr"));
    for (std::string line; std::getline(log, line);)
      if (line.find("CONSOLE") != line.npos) lines += line + "\n";
    return lines;
  }

  TemporaryFolder folder_;
  std::string theme_;
};

#define LAKE_SKIP_WITHOUT_BROWSER() \
  if (Browser::Find().empty()) GTEST_SKIP() << "no chromium is installed (Debian package chromium)"

}  // namespace lake
