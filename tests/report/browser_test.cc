// Reports as a browser shows them.
#include "browser.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/report/report.h"
#include "lake/video/image.h"

namespace lake {
namespace {

using namespace report;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kHostile = "<b>knee</b></script><script>throw 'inside'</script>\"'&";

// A square path of 100 mm by 60 mm, so that unequal scales would show.
LineChart PathChart() {
  LineChart chart;
  chart.title = "Paths";
  chart.equal_scales = true;
  chart.x.label = "x (mm)";
  chart.y.label = "y (mm)";
  chart.series = {{.name = kHostile,
                   .x = {0, 100, 100, 0},
                   .y = {0, 0, 60, 60},
                   .colour = colour::kHuman,
                   .labels = {"0 %", "30 %", "60 %", "100 %"}}};
  return chart;
}

LineChart CurveChart() {
  LineChart chart;
  chart.title = "Error";
  chart.x = {"percent", 0, 100};
  chart.y.label = "mm";
  Series curve{.name = "error", .colour = colour::kExoskeleton};
  for (int i = 0; i <= 100; ++i) {
    const double y = 5 + 3 * std::sin(2 * std::numbers::pi * i / 100);
    curve.x.push_back(i);
    curve.y.push_back(i == 50 ? kNaN : y);
    curve.lower.push_back(y - 1);
    curve.upper.push_back(y + 1);
  }
  chart.series = {curve, {.name = "spike", .x = {30}, .y = {7}, .mark = Mark::kPoints}};
  chart.lines = {{40, "seat-off"}};
  chart.intervals = {{60, 80, "gap"}};
  return chart;
}

BarChart ShareChart() {
  BarChart chart;
  chart.title = "Parts";
  chart.categories = {"placement", "timing", "shape"};
  chart.value_axis.label = "%";
  chart.series = {{.name = "share", .values = {62, 40, -2}, .lower = {55, 33, kNaN}, .upper = {70, 48, kNaN}}};
  return chart;
}

std::string SamplePage() {
  const Table table{"Figures", {{"What"}, {"mm", 3}}, {{"a figure with a long name that has to wrap", 1.0}}};
  return RenderReport({kHostile,
                       kHostile,
                       {"a warning"},
                       {{"Charts", {PathChart(), CurveChart(), ShareChart()}},
                        {"Numbers", {KeyFigures{{{"error", 1.5, 2, "mm", 0.1, "note"}}}, table}}}});
}

// Helpers for the probes: charts by their order, waiting for two frames, the mouse.
const std::string kProbe = R"(
  const canvases = [...document.querySelectorAll('canvas')];
  const charts = canvases.map(canvas => Chart.getChart(canvas));
  const frames = async () => { for (let i = 0; i < 2; ++i) await new Promise(requestAnimationFrame); };
  const pixel = (chart, x, y) => ({x: chart.scales.x.getPixelForValue(x), y: chart.scales.y.getPixelForValue(y)});
  const mouse = (chart, type, at, more = {}) => {
    const box = chart.canvas.getBoundingClientRect(), Kind = type.startsWith('pointer') ? PointerEvent : MouseEvent;
    chart.canvas.dispatchEvent(new Kind(type, {clientX: box.left + at.x, clientY: box.top + at.y, bubbles: true,
                                               pointerType: 'mouse', pointerId: 1, ...more}));
  };
  canvases.forEach(canvas => canvas.setPointerCapture = () => {});  // a made-up pointer cannot be captured
  const view = ({scales: {x, y}}) => [x.min, x.max, y.min, y.max];
  const ratiosOfScales = () => {  // of the first chart as it is shown, a part of it, and nearer
    const ratio = ({scales: {x, y}}) => (x.max - x.min) / x.width / ((y.max - y.min) / y.height);
    const chart = charts[0], ratios = [ratio(chart)];
    mouse(chart, 'pointerdown', pixel(chart, 10, 50));
    mouse(chart, 'pointermove', pixel(chart, 90, 30));
    mouse(chart, 'pointerup', pixel(chart, 90, 30));
    ratios.push(ratio(chart));
    [...document.querySelectorAll('.tools button')].find(button => button.textContent === '+').click();
    ratios.push(ratio(chart));
    return ratios;
  };
)";

// What a reader does on the sample page, in one visit of a wide and in one of a narrow window, as a browser takes
// longer to begin than for all of this. Each part leaves the page as it found it, but for the last two.
const Json& OnTheWidePage() {
  static const Json answers = Browser().Ask(SamplePage(), kProbe + R"(
    const answers = {};
    answers.page = {charts: charts.length, titles: [document.title, document.querySelector('h1').textContent],
                    legend: charts[1].legend.legendItems.map(item => item.text),
                    loaded: performance.getEntriesByType('resource').length};
    {
      const at = charts[1].data.datasets.findIndex(dataset => dataset.label === 'error' && !dataset.isBand);
      answers.skipped = charts[1].getDatasetMeta(at).data.map((point, i) => point.skip ? i : -1).filter(i => i >= 0);
    }
    {
      const shown = async (chart, x, y) => {
        mouse(chart, 'mousemove', pixel(chart, x, y));
        await frames();
        const {opacity, title, body} = chart.tooltip, lines = body.map(b => b.lines.join());
        mouse(chart, 'mouseout', pixel(chart, x, y));
        return [opacity, title.join(), lines];
      };
      answers.hovered = [await shown(charts[0], 99, 59), await shown(charts[1], 25.2, 4),
                         await shown(charts[2], 10, 'timing')];
      await frames();
    }
    {
      const chart = charts[1], home = view(chart), a = pixel(chart, 20, 8), b = pixel(chart, 60, 4);
      const drag = (from, to, more) => {
        mouse(chart, 'pointerdown', from, more);
        mouse(chart, 'pointermove', to, more);
        mouse(chart, 'pointerup', to, more);
      };
      drag(a, b, {});
      const zoomed = view(chart);
      drag(pixel(chart, 30, 6), pixel(chart, 40, 6), {shiftKey: true});
      const panned = view(chart);
      mouse(chart, 'dblclick', a);
      answers.dragged = {home, zoomed, panned, again: view(chart)};
    }
    {
      const chart = charts[1], home = view(chart), box = chart.canvas.getBoundingClientRect(), at = pixel(chart, 25, 5);
      const wheel = more => chart.canvas.dispatchEvent(new WheelEvent('wheel', {
        clientX: box.left + at.x, clientY: box.top + at.y, deltaY: -100, cancelable: true, ...more}));
      const scrolls = wheel({}), untouched = view(chart), taken = !wheel({ctrlKey: true});
      answers.wheel = {scrolls, same: String(untouched) === String(home), taken, zoomed: view(chart)};
      mouse(chart, 'dblclick', at);
    }
    {
      const saved = [], click = HTMLAnchorElement.prototype.click;
      HTMLAnchorElement.prototype.click = function () { saved.push([this.download, decodeURIComponent(this.href)]); };
      for (const button of document.querySelectorAll('.tools button'))
        if (['PNG', 'CSV'].includes(button.textContent)) button.click();
      HTMLAnchorElement.prototype.click = click;
      answers.saved = saved.map(([name, url]) => [name, url.slice(0, 150)]);
    }
    {
      const chart = charts[1], {legend} = chart, item = legend.legendItems[0];
      legend.options.onClick.call(legend, null, item, legend);
      answers.visible = chart.data.datasets.map((dataset, i) => chart.isDatasetVisible(i));
    }
    answers.ratios = ratiosOfScales();
    return answers;)");
  return answers;
}

const Json& OnTheNarrowPage() {
  static const Json answers = Browser().Ask(SamplePage(), kProbe + R"(
    return {widths: [document.documentElement.scrollWidth, window.innerWidth], ratios: ratiosOfScales()};)",
                                            390);
  return answers;
}

int PixelsOf(const cv::Mat& image, const char* colour) {
  const int rgb = std::stoi(std::string(colour).substr(1), nullptr, 16);
  int count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const auto& p = image.at<cv::Vec3b>(y, x);
      count += (p[2] << 16 | p[1] << 8 | p[0]) == rgb;
    }
  return count;
}

TEST(ReportInBrowser, ErrorsOfAPageAreSeenByTheseTests) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const std::string page = RenderReport({"T", "", {}, {{"S", {Paragraph{"text"}}}}});
  EXPECT_THAT(Browser().Open(page).console, IsEmpty());
  std::string failing = page;
  failing.insert(failing.rfind("</body>"), "<script>throw new Error('seen')</script>");
  EXPECT_THAT(Browser().Open(failing).console, HasSubstr("seen"));
  // What a page should load from elsewhere is refused by its own policy.
  std::string loading = page;
  loading.insert(loading.rfind("</body>"), "<img src=\"http://127.0.0.1:9/x.png\">");
  EXPECT_THAT(Browser().Open(loading).console, HasSubstr("Content Security Policy"));
}

TEST(ReportInBrowser, DrawsEveryChartWithoutAnError) {
  LAKE_SKIP_WITHOUT_BROWSER();
  EXPECT_THAT(Browser().Open(SamplePage()).console, IsEmpty());
  const Json& answer = OnTheWidePage()["page"];
  EXPECT_EQ(answer["charts"], 3);
  EXPECT_EQ(answer["titles"], Json({kHostile, kHostile}));
  EXPECT_EQ(answer["legend"], Json({"error", "spike"}));  // and not the band's edges
  EXPECT_EQ(answer["loaded"], 0);
}

TEST(ReportInBrowser, ColoursAreOnTheScreenWideAndNarrow) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  for (const int width : {1280, 390}) {
    const cv::Mat picture = video::ReadImage(browser.Screenshot(SamplePage(), width, 2600), true);
    EXPECT_EQ(picture.cols, width);
    // A line 2 px wide around a path and over a chart; the half-covered pixels at its edges have other colours.
    EXPECT_GT(PixelsOf(picture, colour::kHuman), 300) << width;
    EXPECT_GT(PixelsOf(picture, colour::kExoskeleton), 50) << width;
    EXPECT_GT(PixelsOf(picture, colour::kAnkle), 2000) << width;  // bars
  }
}

// Two conditions that agree are both seen, in their colours.
TEST(ReportInBrowser, ADashedLineLeavesWhatItCoversBetweenItsDashes) {
  LAKE_SKIP_WITHOUT_BROWSER();
  LineChart chart{.title = "Agree", .x = {"percent"}, .y = {"mm"}};
  chart.series = {{.name = "without", .x = {0, 1}, .y = {1, 1}, .colour = colour::kHuman},
                  {.name = "with", .x = {0, 1}, .y = {1, 1}, .colour = colour::kExoskeleton, .mark = Mark::kDashed}};
  Browser browser;
  const cv::Mat picture =
      video::ReadImage(browser.Screenshot(RenderReport({"T", "", {}, {{"S", {chart}}}}), 1000, 700), true);
  EXPECT_GT(PixelsOf(picture, colour::kHuman), 200);
  EXPECT_GT(PixelsOf(picture, colour::kExoskeleton), 200);
}

TEST(ReportInBrowser, NothingSticksOutOfANarrowPage) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json& widths = OnTheNarrowPage()["widths"];
  EXPECT_LE(widths[0], widths[1]);
}

TEST(ReportInBrowser, ANaNIsAGap) {
  LAKE_SKIP_WITHOUT_BROWSER();
  EXPECT_EQ(OnTheWidePage()["skipped"], Json({50}));
}

TEST(ReportInBrowser, HoverShowsValues) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json& answer = OnTheWidePage()["hovered"];
  EXPECT_EQ(answer[0], Json({1, "60 %", {" " + kHostile + ": 100, 60"}}));
  EXPECT_EQ(answer[1], Json({1, "percent: 25", {" error: 8 (7 to 9)"}}));
  EXPECT_EQ(answer[2], Json({1, "timing", {" share: 40.0 (33.0 to 48.0)"}}));
}

TEST(ReportInBrowser, ADragZoomsAndADoubleClickShowsAll) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json& answer = OnTheWidePage()["dragged"];
  const double kPixel = 0.2;  // a coordinate of the mouse is a whole px, of 100 % over some 1000 px
  const Json zoomed = {20, 60, 4, 8}, panned = {10, 50, 4, 8};
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(answer["zoomed"][i].get<double>(), zoomed[i].get<double>(), kPixel) << i;
    EXPECT_NEAR(answer["panned"][i].get<double>(), panned[i].get<double>(), kPixel) << i;
  }
  EXPECT_EQ(answer["again"], answer["home"]);
}

TEST(ReportInBrowser, AMillimetreIsAsLongOnBothAxesWhateverTheView) {
  LAKE_SKIP_WITHOUT_BROWSER();
  for (const Json* page : {&OnTheWidePage(), &OnTheNarrowPage()}) {
    const Json& ratios = (*page)["ratios"];
    ASSERT_EQ(ratios.size(), 3u);
    // The labels of the axes take a px more or less after the last correction.
    for (const Json& ratio : ratios) EXPECT_NEAR(ratio.get<double>(), 1, 0.02) << ratios;
  }
}

TEST(ReportInBrowser, TheWheelZoomsAtThePointerWithControlOnly) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json& answer = OnTheWidePage()["wheel"];
  EXPECT_EQ(answer["scrolls"], true);
  EXPECT_EQ(answer["same"], true);
  EXPECT_EQ(answer["taken"], true);
  // Factor 1.2 around 25 of 0..100; within a px of the mouse.
  EXPECT_NEAR(answer["zoomed"][0].get<double>(), 25 - 25 / 1.2, 0.2);
  EXPECT_NEAR(answer["zoomed"][1].get<double>(), 25 + 75 / 1.2, 0.2);
}

TEST(ReportInBrowser, SavesThePictureAndTheValues) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const Json& saved = OnTheWidePage()["saved"];
  ASSERT_EQ(saved.size(), 6);
  EXPECT_EQ(saved[0][0], "paths.png");
  EXPECT_THAT(saved[0][1].get<std::string>(), HasSubstr("data:image/png;base64,iVBOR"));
  EXPECT_THAT(saved[1][1].get<std::string>(), HasSubstr("series,x,y,lower,upper\n\"<b>knee</b></script>"));
  EXPECT_THAT(saved[3][1].get<std::string>(), HasSubstr("series,x,y,lower,upper\n\"error\",0,5,4,6\n"));
  EXPECT_THAT(saved[5][1].get<std::string>(), HasSubstr("\"share\",\"shape\",-2,,\n"));
}

TEST(ReportInBrowser, ANameInTheLegendHidesItsLineAndItsBand) {
  LAKE_SKIP_WITHOUT_BROWSER();
  EXPECT_EQ(OnTheWidePage()["visible"], Json({false, false, false, true}));
}

// By session, then by name, which takes the others' curves away and brings them back; no choice where there is none.
TEST(ReportInBrowser, AReaderChoosesRowsAndTheirCurves) {
  LAKE_SKIP_WITHOUT_BROWSER();
  LineChart chart{.title = "Everyone", .x = {"percent"}, .y = {"mm"}};
  for (const char* name : {"mean", "sub-01", "sub-02"})
    chart.series.push_back({.name = name, .x = {0, 1}, .y = {1, 2}, .mark = Mark::kThin});
  chart.series[0].mark = Mark::kLine;
  const Table table{"Each",
                    {{"Who"}, {"Session"}, {"Run"}, {"mm", 1}},
                    {{Link{"a.html", "sub-01"}, "ses-1", "", 1.0},
                     {Link{"b.html", "sub-01"}, "ses-2", "", 2.0},
                     {Link{"c.html", "sub-02"}, "", "", 3.0}},
                    Width::kFull,
                    {0, 1, 2}};
  const Json answer = Browser().Ask(RenderReport({"T", "", {}, {{"S", {chart, table}}}}), kProbe + R"(
    const selects = [...document.querySelectorAll('.filters select')];
    const rows = () => [...document.querySelectorAll('tbody tr')].map(row => row.offsetHeight > 0 ? 1 : 0).join('');
    const curves = () => [0, 1, 2].map(i => charts[0].isDatasetVisible(i) ? 1 : 0).join('');
    const choose = (i, value) => {
      selects[i].value = value;
      selects[i].dispatchEvent(new Event('change'));
      return [rows(), curves(), document.querySelector('.filters output').textContent];
    };
    return [selects.length, rows(), choose(1, 'ses-2'), choose(1, '\u2013'), choose(1, ''), choose(0, 'sub-02'),
            choose(0, '')];)");
  EXPECT_EQ(answer, Json({2,
                          "111",
                          {"010", "111", "1 of 3 rows"},
                          {"001", "111", "1 of 3 rows"},
                          {"111", "111", "3 of 3 rows"},
                          {"001", "101", "1 of 3 rows"},
                          {"111", "111", "3 of 3 rows"}}))
      << answer;
}

TEST(ReportInBrowser, LinesAreSeenOnADarkPage) {
  LAKE_SKIP_WITHOUT_BROWSER();
  LineChart chart{.title = "Fronts", .x = {"deg"}, .y = {"%"}};
  for (const char* colour : {"#555555", colour::kAnkle, colour::kGuide, colour::kText})
    chart.series.push_back({.name = colour, .x = {0, 1}, .y = {1, 2}, .colour = colour});
  Browser browser;
  browser.PreferDark();
  const Json contrasts = browser.Ask(RenderReport({"T", "", {}, {{"S", {chart}}}}), kProbe + R"(
    const linear = c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    const light = colour => [1, 3, 5].map(at => linear(parseInt(colour.slice(at, at + 2), 16) / 255))
      .reduce((sum, c, i) => sum + [0.2126, 0.7152, 0.0722][i] * c, 0.05);
    return charts[0].data.datasets.map((dataset, i) =>
      light(charts[0].getDatasetMeta(i).dataset.options.borderColor) / light('#1a1b1d'));)");
  ASSERT_EQ(contrasts.size(), 4u);
  for (const Json& contrast : contrasts) EXPECT_GE(contrast.get<double>(), 2.99) << contrasts;
}

TEST(ReportInBrowser, PrintsPicturesOfTheCharts) {
  LAKE_SKIP_WITHOUT_BROWSER();
  Browser browser;
  const Json answer = browser.Ask(SamplePage(), kProbe + R"(
    dispatchEvent(new Event('beforeprint'));
    const images = [...document.querySelectorAll('.printed')];
    // Loading holds the browser's virtual time, decoding does not: the page would be left before it ends.
    await Promise.all(images.map(image => image.complete || new Promise(loaded => image.onload = loaded)));
    const printed = images.map(image => image.naturalWidth);
    dispatchEvent(new Event('afterprint'));
    return {printed, left: document.querySelectorAll('.printed').length};)");
  EXPECT_EQ(answer["printed"], Json({2720, 2720, 2720}));  // 680 px of paper at 4 px each
  EXPECT_EQ(answer["left"], 0);
  EXPECT_EQ(ReadTextFile(browser.Print(SamplePage())).substr(0, 5), "%PDF-");
}

// On an upright page the type of a drawing of 1400 px, 14 px high, would be of 5 pt.
TEST(ReportInBrowser, PrintsWideDrawingsOnAPageAcross) {
  LAKE_SKIP_WITHOUT_BROWSER();
  const TemporaryFolder folder;
  const auto pages_across = [&](int width_px) {
    WriteTextFile(
        folder / "drawing.svg",
        fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"600\" viewBox=\"0 0 {0} "
                    "600\"><text x=\"9\" y=\"99\" font-size=\"14\">wide</text></svg>",
                    width_px));
    Browser browser;
    const std::string pdf = ReadTextFile(
        browser.Print(RenderReport({"T", "", {}, {{"S", {Picture{folder / "drawing.svg", "a drawing", ""}}}}})));
    const std::string box = "/MediaBox [0 0 ";
    int across = 0;
    for (std::size_t at = pdf.find(box); at != pdf.npos; at = pdf.find(box, at + 1)) {
      double wide_pt = 0, high_pt = 0;
      std::istringstream(pdf.substr(at + box.size(), 40)) >> wide_pt >> high_pt;
      across += wide_pt > high_pt ? 1 : 0;
    }
    return across;
  };
  EXPECT_EQ(pages_across(1400), 1);
  EXPECT_EQ(pages_across(1000), 0);
}

TEST(ReportInBrowser, WithoutJavaScriptTablesAndPicturesAreThere) {
  LAKE_SKIP_WITHOUT_BROWSER();
  TemporaryFolder folder;
  video::WriteImage(folder / "blue.png", cv::Mat(200, 300, CV_8UC3, cv::Scalar(178, 114, 0)));
  std::string page =
      RenderReport({"T", "", {}, {{"S", {Picture{folder / "blue.png", "a blue field", "Blue"}, CurveChart()}}}});
  const std::string allowed = "script-src 'unsafe-inline'";
  page.replace(page.find(allowed), allowed.size(), "script-src 'none'");
  const cv::Mat picture = video::ReadImage(Browser().Screenshot(page, 800, 1000), true);
  EXPECT_EQ(PixelsOf(picture, colour::kAnkle), 200 * 300);
  EXPECT_EQ(PixelsOf(picture, colour::kExoskeleton), 0);
}

}  // namespace
}  // namespace lake
