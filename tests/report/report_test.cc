#include "lake/report/report.h"

#include <gmock/gmock.h>

#include <limits>
#include <regex>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using namespace report;
using testing::HasSubstr;
using testing::Not;

const std::string kHostileText = "</script><img src=x onerror=\"alert('1')\">&\x01\xFF";

LineChart SmallChart() {
  LineChart chart;
  chart.title = "Angle";
  chart.series = {{.name = "knee", .x = {0, 1, 2}, .y = {1, kNaN, 3}}};
  return chart;
}

std::string PageOf(std::vector<Block> blocks) {
  return RenderReport({"Title", "", {}, {{"Section", std::move(blocks)}}});
}

std::string ChartJson(const std::string& page) {
  const std::string begin = "<script type=\"application/json\">";
  const std::size_t from = page.find(begin) + begin.size();
  return page.substr(from, page.find("</script>", from) - from);
}

TEST(Report, IsOneFileThatReachesForNothing) {
  const std::string page = PageOf({SmallChart(), Files{{{"a b/c#1.csv", "table"}}}});
  EXPECT_THAT(page, HasSubstr("<html lang=\"en\">"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  // No element that loads, and no address that is not inside the file, but for links to click.
  EXPECT_FALSE(std::regex_search(page, std::regex("<(link|iframe|object|embed|base)[ >]")));
  EXPECT_FALSE(std::regex_search(page, std::regex("(src|srcset|poster)=\"(?!data:)")));
  EXPECT_FALSE(std::regex_search(page, std::regex("url\\(|@import")));
  EXPECT_THAT(page, HasSubstr("href=\"./a%20b/c%231.csv\""));
}

TEST(Report, CarriesTheLicenceOfItsChartLibrary) {
  const std::string page = PageOf({SmallChart()});
  EXPECT_THAT(page, HasSubstr("Chart.js v3"));
  EXPECT_THAT(page, HasSubstr("Permission is hereby granted, free of charge"));
  EXPECT_THAT(PageOf({Paragraph{"no chart"}}), Not(HasSubstr("<script")));
}

TEST(Report, EscapesEveryText) {
  BarChart bars;
  bars.title = bars.alt = bars.value_axis.label = kHostileText;
  bars.categories = {kHostileText};
  bars.series = {{.name = kHostileText, .values = {1}}};
  LineChart lines = SmallChart();
  lines.title = lines.caption = lines.x.label = lines.series[0].name = kHostileText;
  lines.series[0].labels = {kHostileText, "", ""};
  const std::vector<Block> blocks = {Paragraph{kHostileText},
                                     List{{kHostileText}},
                                     KeyFigures{{{kHostileText, 1, 2, kHostileText, {}, kHostileText}}},
                                     Table{kHostileText, {{kHostileText}}, {{kHostileText}}},
                                     Files{{{kHostileText, kHostileText}}},
                                     bars,
                                     lines};
  const std::string page = RenderReport({kHostileText, kHostileText, {kHostileText}, {{kHostileText, blocks}}});
  EXPECT_THAT(page, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(page, Not(HasSubstr("</script><img")));
  EXPECT_THAT(page, Not(HasSubstr("\x01")));
  EXPECT_THAT(page, Not(HasSubstr("\xFF")));
  EXPECT_THAT(page, HasSubstr("&lt;/script&gt;&lt;img src=x onerror=&quot;alert(&#39;1&#39;)&quot;&gt;&amp;"));
}

TEST(Report, ChartDataReadBackAsTheyWere) {
  LineChart chart = SmallChart();
  chart.series[0].name = "</script>";
  chart.series[0].y = {0.1, kNaN, -std::numeric_limits<double>::infinity()};
  const Json data = Json::parse(ChartJson(PageOf({chart})));
  EXPECT_EQ(data["series"][0]["name"], "</script>");
  EXPECT_EQ(data["series"][0]["y"], Json::parse("[0.1, null, null]"));
}

TEST(Report, ATableMayLinkAndBeFiltered) {
  Table table{"Everyone", {{"Who"}, {"mm", 1}}, {{Link{"../sub 1/a\"b.html", "<sub-01>"}, 1.25}}};
  const std::string plain = RenderReport({"T", "", {}, {{"S", {table}}}});
  EXPECT_THAT(plain, HasSubstr("<th scope=\"row\"><a href=\"./../sub%201/a%22b.html\">&lt;sub-01&gt;</a></th>"));
  EXPECT_THAT(plain, Not(HasSubstr("<script>")));
  table.filters = {0, 1};
  EXPECT_THAT(RenderReport({"T", "", {}, {{"S", {table}}}}), HasSubstr("data-filters=\"0 1\""));
}

// What a reader sees has them on one line; what is copied, a command or a file's name, is as it was.
TEST(Report, ANumberAndItsUnitStayOnOneLine) {
  const Table table{
      "", {{"way"}, {"time"}, {.heading = "command", .code = true}}, {{"new", "20 s, 7.3 %", "--at 3 m"}}};
  const std::string page = PageOf(
      {Paragraph{"It holds 40 N m, 32 mm back; 3 made, 2 steps; 4.7 ± 9 mm at 95 %, 2.1–3.4 mm – as of 2026"}, table});
  EXPECT_THAT(page, HasSubstr("<p>It holds 40\u00A0N\u00A0m, 32\u00A0mm back; 3 made, 2 steps; "
                              "4.7\u00A0±\u00A09\u00A0mm at 95\u00A0%, 2.1–\u20603.4\u00A0mm – as of 2026</p>"));
  EXPECT_THAT(page, HasSubstr("<td>20\u00A0s, 7.3\u00A0%</td>"));
  EXPECT_THAT(page, HasSubstr("--at 3 m</td>"));
}

TEST(Report, WarningsFollowTheMessage) {
  const std::string page =
      RenderReport({"T", "", {"beware"}, {{"Message", {Paragraph{"text"}}}, {"Numbers", {Paragraph{"text"}}}}});
  EXPECT_LT(page.find("Message"), page.find("beware"));
  EXPECT_LT(page.find("beware"), page.find("Numbers"));
  EXPECT_THAT(page, Not(HasSubstr("<details>")));
  EXPECT_THAT(RenderReport({"T", "", {}, {}}), Not(HasSubstr("Warnings")));
}

TEST(Report, WarningsOfALongReportAreFolded) {
  const std::string page =
      RenderReport({"T", "", {"beware"}, {{"Message", {}}, {"A", {}}, {"B", {}}, {"C", {}}, {"D", {}}}});
  EXPECT_THAT(page, HasSubstr("<details>\n<summary><h2>Warnings</h2></summary>\n<ul>\n<li>beware</li>"));
}

TEST(Report, NumbersAsOneReadsThem) {
  const std::string page = PageOf(
      {Table{"", {{"what"}, {"value", 2}, {"none"}}, {{"a", -1.005, 1.0}, {"b", kNaN, 2.0}, {"c", -0.001, kNaN}}},
       KeyFigures{{{"error", 8.614, 2, "%", 0.3, "note"}}}});
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">−1.00</td>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">–</td>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">0.00</td>"));
  EXPECT_THAT(page, HasSubstr("8.61<span class=\"pm\"> ± 0.30</span><span class=\"unit\"> %</span>"));
}

TEST(Report, PicturesAreInsideByTheirContent) {
  TemporaryFolder folder;
  WriteTextFile(folder / "a.txt", std::string("\x89PNG\r\n\x1A\n") + "abc");
  EXPECT_THAT(PageOf({Picture{folder / "a.txt", "a \"knee\"", "caption"}}),
              HasSubstr("<img alt=\"a &quot;knee&quot;\" src=\"data:image/png;base64,iVBORw0KGgphYmM=\">"));
  WriteTextFile(folder / "b", std::string("\0\0\0\x18"
                                          "ftypisom",
                                          12));
  EXPECT_THAT(PageOf({Picture{folder / "b", "film", ""}}), HasSubstr("src=\"data:video/mp4;base64,AAAAGGZ0eXBpc29t\""));
  WriteTextFile(folder / "c.png", "text");
  EXPECT_THROW(PageOf({Picture{folder / "c.png", "", ""}}), Error);
  EXPECT_THROW(PageOf({Picture{folder / "absent.png", "", ""}}), Error);
}

// With names that no other drawing of the page has; what would run a script is a picture, which runs none.
TEST(Report, DrawingsAreElementsOfThePage) {
  TemporaryFolder folder;
  const auto page = [&](const std::string& inside) {
    WriteTextFile(folder / "a.svg", "<?xml version=\"1.0\"?>\n<svg \n width=\"1000\" height=\"500\"><title>a</title>" +
                                        inside + "<path id='m'/><use xlink:href='#m' fill='url(#m)'/></svg>\n");
    return PageOf({Picture{folder / "a.svg", "a \"knee\"", "caption"}});
  };
  const std::string drawn = page("<text>1</text>"), other = page("<text>2</text>");
  EXPECT_THAT(drawn, HasSubstr("role=\"img\" aria-label=\"a &quot;knee&quot;\" style=\"--wide: 1000px\"><svg"));
  EXPECT_THAT(drawn, Not(HasSubstr("<title>a</title>")));
  const auto name_in = [](const std::string& text) {
    std::smatch names;
    EXPECT_TRUE(
        std::regex_search(text, names, std::regex("id='(.+?)'/><use xlink:href='#(.+?)' fill='url\\(#(.+?)\\)'")));
    EXPECT_EQ(names[1], names[2]);
    EXPECT_EQ(names[1], names[3]);
    return names[1].str();
  };
  EXPECT_NE(name_in(drawn), name_in(other));
  for (const char* hostile : {"<script>alert(1)</script>", "<g onload=\"alert(1)\"/>",
                              "<a href=\"JavaScript:alert(1)\"/>", "<foreignObject/>"}) {
    EXPECT_THAT(page(hostile), HasSubstr("<img alt=\"a &quot;knee&quot;\" src=\"data:image/svg+xml;base64,"))
        << hostile;
    EXPECT_THAT(page(hostile), Not(HasSubstr(hostile)));
  }
}

TEST(Report, UnequalColumnsAreNamed) {
  LineChart chart = SmallChart();
  chart.series[0].lower = {1, 2};
  EXPECT_THAT(
      [&] { PageOf({chart}); },
      testing::ThrowsMessage<Error>("report: chart 'Angle', series 'knee': 2 values in lower where 3 are needed"));
  chart = SmallChart();
  chart.series[0].lower = {1, 2, 3};
  EXPECT_THAT([&] { PageOf({chart}); }, testing::ThrowsMessage<Error>(HasSubstr("0 values in upper where 3")));
  EXPECT_THROW(PageOf({Table{"t", {{"a"}, {"b"}}, {{"x"}}}}), Error);
  BarChart bars;
  bars.categories = {"a", "b"};
  bars.series = {{.name = "s", .values = {1}}};
  EXPECT_THROW(PageOf({bars}), Error);
}

TEST(Report, NothingIsWrittenWhenAPictureFails) {
  TemporaryFolder folder;
  EXPECT_THROW(WriteReport(folder / "report.html", {"T", "", {}, {{"S", {Picture{folder / "no.png", "", ""}}}}}),
               Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
}

TEST(Report, ProvenanceNamesVersionCommandAndInputs) {
  const Json head = {{"program", "lake-x"},
                     {"version", "1.2"},
                     {"command", "lake-x a & b"},
                     {"options", {{"seed", 1}}},
                     {"inputs", {{{"path", "a.csv"}, {"sha256", "abc123"}}}},
                     {"warnings", Json::array()}};
  const std::string page = RenderReport({"T", "", {}, {ProvenanceSection(head)}});
  for (const char* text : {"lake-x 1.2", "lake-x a &amp; b", "option seed", "a.csv", "abc123"})
    EXPECT_THAT(page, HasSubstr(text));
}

}  // namespace
}  // namespace lake
