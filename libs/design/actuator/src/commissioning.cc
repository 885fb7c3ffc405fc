#include "lake/actuator/commissioning.h"

#include <fmt/format.h>

#include <vector>

#include "homing.h"
#include "pin_name.h"

namespace lake::actuator {
namespace {

// A wire from a pin of the board to the right: what stands in it, what pulls it down, where it goes.
struct WireRow {
  std::string pin, in_line, pull_down, to;
};

std::vector<WireRow> RowsOf(const FirmwareOptions& o) {
  const Pins& pins = o.pins;
  std::vector<WireRow> rows = {
      {PinName(pins.ena), "", "10 kΩ", "ENA, its jumper removed; PWM of 4 kHz"},
      {PinName(pins.in1), "", "", "IN1: high extends; if it retracts, swap the motor's leads"},
      {PinName(pins.in2), "", "", "IN2: high retracts"},
      {PinName(pins.retract), "", "", "retract end stop, normally closed, to GND"},
      {PinName(pins.extend), "", "", "extend end stop, normally closed, to GND"},
  };
  if (o.bridge_sense) {
    rows.push_back({PinName(pins.out1), "22 kΩ", "15 kΩ", "bridge OUT1, read back"});
    rows.push_back({PinName(pins.out2), "22 kΩ", "15 kΩ", "bridge OUT2, read back"});
  }
  rows.push_back({"A0", "", "1 MΩ", fmt::format("wiper of the potentiometer between {} V and GND", kReference_v)});
  if (o.current_sense) rows.push_back({"A1", "", "100 kΩ", "output of the ACS712-05B in the motor's line"});
  if (o.supply_v > 0) rows.push_back({"A2", "39 kΩ", "10 kΩ", "the motor's supply at the bridge"});
  if (pins.safety_relay)
    rows.push_back({PinName(*pins.safety_relay), "", "10 kΩ", "driver of the safety relay's coil"});
  if (pins.hold_button)
    rows.push_back({PinName(*pins.hold_button), "", "", "button, normally open, to GND: held while anything moves"});
  rows.push_back({"GND", "", "", "bridge GND, sensors' GND, minus of the supply: at one point"});
  return rows;
}

constexpr int kTop = 210, kStep = 46, kBoardRight = 170, kTargetLeft = 500;

std::string Line(int x1, int y1, int x2, int y2) {
  return fmt::format("<path d='M{} {}L{} {}'/>\n", x1, y1, x2, y2);
}

std::string Text(int x, int y, const std::string& text) {
  return fmt::format("<text x='{}' y='{}'>{}</text>\n", x, y, text);
}

std::string Box(int x, int y, int width, int height) {
  return fmt::format("<rect x='{}' y='{}' width='{}' height='{}'/>\n", x, y, width, height);
}

// A box in the line from x to the right, and what it is above it.
std::string InLine(int x, int y, const std::string& what) {
  return Box(x, y - 6, 46, 12) + Text(x, y - 11, what);
}

std::string RowSvg(const WireRow& row, int y) {
  std::string svg = Text(kBoardRight - 46, y + 5, row.pin);
  svg += row.in_line.empty()
             ? Line(kBoardRight, y, kTargetLeft - 10, y)
             : Line(kBoardRight, y, 330, y) + InLine(330, y, row.in_line) + Line(376, y, kTargetLeft - 10, y);
  if (!row.pull_down.empty())
    svg += Line(240, y, 240, y + 8) + Box(234, y + 8, 12, 20) + Line(240, y + 28, 240, y + 33) +
           Line(230, y + 33, 250, y + 33) + Text(254, y + 24, row.pull_down);
  return svg + Text(kTargetLeft, y + 5, row.to);
}

// From the supply to the motor, in the order in which the current goes.
std::string SupplySvg(const FirmwareOptions& o) {
  std::vector<std::string> parts = {fmt::format("fuse {:.1f} A", o.StallCurrent()), "emergency stop"};
  if (o.pins.safety_relay) parts.push_back("safety relay");
  std::string svg = Text(40, 115, o.supply_v > 0 ? fmt::format("+{:g} V", o.supply_v) : "+ supply");
  int x = 100;
  for (const std::string& part : parts) {
    svg += Line(x, 110, x + 60, 110) + Box(x + 60, 104, 46, 12) + Text(x + 36, 96, part);
    x += 106;
  }
  svg += Line(x, 110, x + 40, 110) + Box(x + 40, 88, 100, 44) + Text(x + 52, 115, "L298N");
  x += 140;
  if (o.current_sense) {
    svg += Line(x, 110, x + 40, 110) + Box(x + 40, 104, 60, 12) + Text(x + 36, 96, "ACS712");
    x += 100;
  }
  svg += Line(x, 110, x + 50, 110);
  return svg + fmt::format("<circle cx='{}' cy='110' r='22'/>\n", x + 72) + Text(x + 66, 115, "M") +
         Text(x + 104, 115, "actuator");
}

std::string Tick(const std::string& what, const std::string& seen) {
  return fmt::format("| {} | {} | | | |\n", what, seen);
}

}  // namespace

std::string SchematicSvg(const FirmwareOptions& options) {
  const std::vector<WireRow> rows = RowsOf(options);
  const int height = kTop + kStep * static_cast<int>(rows.size()) + 40;
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1040 {0}' width='1040' height='{0}' "
      "font-family='sans-serif' "
      "font-size='14'>\n<rect width='1040' height='{0}' fill='white'/>\n<g fill='none' stroke='black' "
      "stroke-width='1.5'>\n<style>text{{fill:black;stroke:none}}</style>\n",
      height);
  svg += Text(40, 30, "Wiring of this sketch's firmware. Not tried on a board: nobody may wear what it drives.");
  svg += Text(40, 52,
              "The emergency stop is in the hand of who watches. The UNO is fed by USB, not by this "
              "supply.");
  svg += SupplySvg(options);
  svg += Box(40, kTop - 34, kBoardRight - 40, kStep * static_cast<int>(rows.size()) + 24) + Text(52, kTop - 12, "UNO");
  for (std::size_t i = 0; i < rows.size(); ++i) svg += RowSvg(rows[i], kTop + kStep * static_cast<int>(i));
  return svg + "</g>\n</svg>\n";
}

std::string SignOffSheet(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                         const FirmwareOptions& options) {
  const Homing homing = HomingOf(stroke, schedule, table, options);
  std::string text = fmt::format(
      "# Before the first motion\n\n**{}** Each line is done in this order, by two people, and signed. What is not "
      "seen as it "
      "is written ends the work: mend it, and begin again at the first line.\n\nDesign {}, program from {:.3f} mm to "
      "{:.3f} "
      "mm in {:.1f} s. Wiring: `schematic.svg`. What can go wrong, and what notices it: `SAFETY.md`, `RISKS.md`.\n\n"
      "What this firmware cannot know:\n\n",
      kUntried, options.design_hash, stroke.start_mm, schedule.knots.back().stroke_mm, schedule.Duration());
  const std::vector<std::string> unknowns = Unknowns(options, stroke, table);
  for (const std::string& unknown : unknowns) text += "- " + unknown + "\n";
  if (unknowns.empty()) text += "- nothing of what the simulator's faults ask for; much else.\n";
  text += "\n| check | what must be seen | found | name | date |\n| --- | --- | --- | --- | --- |\n";
  text += Tick("mechanical stops before standing and before the dead point", "each holds the actuator's stall force");
  text += Tick("fuse in the motor's supply", fmt::format("{:.1f} A, quick", options.StallCurrent()));
  text += Tick("emergency stop, supply on, nothing moving", "pressed: 0 V at the bridge");
  text += Tick(fmt::format("ENA's jumper removed, 10 kΩ from {} to GND, UNO unplugged", PinName(options.pins.ena)),
               "ENA at 0 V; with the jumper on, `home` gives ALARM:15 and nothing moves");
  text += Tick("each end stop pressed by hand, released", "`stops:` in the answer to `?`: 1 retract, 2 extend, 0");
  text += Tick("each end stop's wire off", "reads as pressed");
  text += Tick(fmt::format("retract end stop at {:.3f} mm", homing.stroke_mm), "measured by a calliper, pin to pin");
  text += options.extend_stop_mm > 0 ? Tick(fmt::format("extend end stop at {:.3f} mm", *ExtendStop(schedule, options)),
                                            "measured by a calliper")
                                     : Tick("extend end stop before the linkage's end", "measured by a calliper");
  if (options.feedback == Feedback::kPotentiometer)
    text +=
        Tick("potentiometer at three strokes", fmt::format("within {} mm of the calliper", options.feedback_error_mm));
  if (options.supply_v > 0)
    text += Tick("supply sense",
                 fmt::format("{:.2f} V at A2 with {:g} V", options.supply_v / kSupplyDivider, options.supply_v));
  if (options.current_sense) text += Tick("current sensor at rest", "`current_a` within 0.05 A of 0");
  if (options.force_limit_n)
    text += Tick("force limit: the rod against a scale, `jog`",
                 fmt::format("ALARM:12 below {:g} N", *options.force_limit_n));
  if (options.pins.safety_relay)
    text += Tick("safety relay", "open after a reset; its contact bridged, `home` gives ALARM:16");
  if (options.pins.hold_button) {
    text += Tick("hold button released, and its wire off, `home`", "error:10, nothing moves");
    text += Tick("hold button released while it jogs", "it stands; `button released, stopped`");
  }
  text += Tick("supply limited to half the stall current, actuator off the leg, in the middle",
               "`jog 400 300` extends by some mm; if it retracts, swap OUT1 and OUT2");
  text += Tick("motor's leads swapped on purpose, `home`", "ALARM:5 or ALARM:9 within 1 mm; then swapped back");
  text += Tick("emergency stop while it jogs, then released", "it stands, and stands on; ALARM:6 with --supply");
  text += Tick("the program ten times without a person", "`done` ten times, no ALARM");
  text += Tick("the bench's plan", "`BENCH.md` of the project: every line is within what `RISKS.md` says");
  return text;
}

}  // namespace lake::actuator
