// The wiring drawn, and the sheet on which each check before the first motion is signed.
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "homing.h"

namespace lake::actuator {
namespace {

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

// A wire from a pin of the board to the right.
std::string RowSvg(const std::string& pin, const Connection& row, int y) {
  std::string svg = Text(kBoardRight - 46, y + 5, pin);
  svg += *row.in_line == 0
             ? Line(kBoardRight, y, kTargetLeft - 10, y)
             : Line(kBoardRight, y, 330, y) + InLine(330, y, row.in_line) + Line(376, y, kTargetLeft - 10, y);
  if (*row.pull_down != 0)
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

// A line to be signed, where it applies.
struct Check {
  bool applies;
  std::string what, seen;
};

}  // namespace

std::string PinName(int pin) {
  return pin < 14 ? fmt::format("D{}", pin) : fmt::format("A{}", pin - 14);
}

std::vector<Connection> ConnectionsOf(const FirmwareOptions& o) {
  const Pins& p = o.pins;
  return {
      {"ENA", "ena", p.ena, true, "", "10 kΩ", "ENA, its jumper removed; PWM of 4 kHz"},
      {"IN1", "in1", p.in1, true, "", "", "IN1: high extends; if it retracts, swap the motor's leads"},
      {"IN2", "in2", p.in2, true, "", "", "IN2: high retracts"},
      {"RETRACT", "retract", p.retract, true, "", "", "retract end stop, normally closed, to GND"},
      {"EXTEND", "extend", p.extend, true, "", "", "extend end stop, normally closed, to GND"},
      {"OUT1", "out1", p.out1, o.bridge_sense, "22 kΩ", "15 kΩ", "bridge OUT1, read back"},
      {"OUT2", "out2", p.out2, o.bridge_sense, "22 kΩ", "15 kΩ", "bridge OUT2, read back"},
      {"", "the potentiometer", 14, true, "", "1 MΩ", "wiper of the potentiometer between 5 V and GND"},
      {"", "the current sensor", 15, o.current_sense, "", "100 kΩ", "output of the ACS712-05B in the motor's line"},
      {"", "the supply sense", 16, o.supply_v > 0, "39 kΩ", "10 kΩ", "the motor's supply at the bridge"},
      {"RELAY", "--safety-relay", p.safety_relay.value_or(0), p.safety_relay.has_value(), "", "10 kΩ",
       "driver of the safety relay's coil"},
      {"BUTTON", "--hold-button", p.hold_button.value_or(0), p.hold_button.has_value(), "", "",
       "button, normally open, to GND: held while anything moves"},
  };
}

std::string SchematicSvg(const FirmwareOptions& options) {
  std::string wires;
  int y = kTop;
  const auto add = [&](const std::string& pin, const Connection& wire) {
    if (wire.is_wired) wires += RowSvg(pin, wire, std::exchange(y, y + kStep));
  };
  for (const Connection& wire : ConnectionsOf(options)) add(PinName(wire.pin), wire);
  add("GND", {"", "", 0, true, "", "", "bridge GND, sensors' GND, minus of the supply: at one point"});
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1040 {0}' width='1040' height='{0}' "
      "font-family='sans-serif' font-size='14'>\n<rect width='1040' height='{0}' fill='white'/>\n"
      "<g fill='none' stroke='black' stroke-width='1.5'>\n<style>text{{fill:black;stroke:none}}</style>\n",
      y + 40);
  svg += Text(40, 30, "Wiring of this sketch's firmware. Not tried on a board: nobody may wear what it drives.");
  svg += Text(40, 52, "The emergency stop is in the hand of who watches. The UNO is fed by USB, not by this supply.");
  svg += SupplySvg(options);
  svg += Box(40, kTop - 34, kBoardRight - 40, y - kTop + 24) + Text(52, kTop - 12, "UNO");
  return svg + wires + "</g>\n</svg>\n";
}

std::string SignOffSheet(const Sketch& sketch) {
  const FirmwareOptions& options = sketch.options;
  std::string text = fmt::format(
      "# Before the first motion\n\n**{}** Each line is done in this order, by two people, and signed. What is not "
      "seen as it is written ends the work: mend it, and begin again at the first line.\n\nDesign {}, program from "
      "{:.3f} mm to {:.3f} mm in {:.1f} s. Wiring: `schematic.svg`. What can go wrong, and what notices it: "
      "`SAFETY.md`, `RISKS.md`.\n\nWhat this firmware cannot know:\n\n",
      kUntried, options.design_hash, sketch.stroke.start_mm, sketch.schedule.knots.back().stroke_mm,
      sketch.schedule.Duration());
  const std::vector<std::string> unknowns = Unknowns(sketch);
  for (const std::string& unknown : unknowns) text += "- " + unknown + "\n";
  if (unknowns.empty()) text += "- nothing of what the simulator's faults ask for; much else.\n";
  text += "\n| check | what must be seen | found | name | date |\n| --- | --- | --- | --- | --- |\n";
  const bool has_extend_stop = options.extend_stop_mm > 0, has_button = options.pins.hold_button.has_value();
  const std::vector<Check> checks = {
      {true, "mechanical stops before standing and before the dead point", "each holds the actuator's stall force"},
      {true, "fuse in the motor's supply", fmt::format("{:.1f} A, quick", options.StallCurrent())},
      {true, "emergency stop, supply on, nothing moving", "pressed: 0 V at the bridge"},
      {true, fmt::format("ENA's jumper removed, 10 kΩ from {} to GND, UNO unplugged", PinName(options.pins.ena)),
       "ENA at 0 V; with the jumper on, `home` gives ALARM:15 and nothing moves"},
      {true, "each end stop pressed by hand, released", "`stops:` in the answer to `?`: 1 retract, 2 extend, 0"},
      {true, "each end stop's wire off", "reads as pressed"},
      {true, fmt::format("retract end stop at {:.3f} mm", sketch.HomeStroke()), "measured by a calliper, pin to pin"},
      {has_extend_stop, fmt::format("extend end stop at {:.3f} mm", sketch.ExtendStop().value_or(0)),
       "measured by a calliper"},
      {!has_extend_stop, "extend end stop before the linkage's end", "measured by a calliper"},
      {options.HasFeedback(), "potentiometer at three strokes",
       fmt::format("within {} mm of the calliper", options.feedback_error_mm)},
      {options.supply_v > 0, "supply sense",
       fmt::format("{:.2f} V at A2 with {:g} V", options.supply_v / kSupplyDivider, options.supply_v)},
      {options.current_sense, "current sensor at rest", "`current_a` within 0.05 A of 0"},
      {options.force_limit_n.has_value(), "force limit: the rod against a scale, `jog`",
       fmt::format("ALARM:12 below {:g} N", options.force_limit_n.value_or(0))},
      {options.pins.safety_relay.has_value(), "safety relay",
       "open after a reset; its contact bridged, `home` gives ALARM:16"},
      {has_button, "hold button released, and its wire off, `home`", "error:10, nothing moves"},
      {has_button, "hold button released while it jogs", "it stands; `button released, stopped`"},
      {true, "supply limited to half the stall current, actuator off the leg, in the middle",
       "`jog 400 300` extends by some mm; if it retracts, swap OUT1 and OUT2"},
      {true, "motor's leads swapped on purpose, `home`", "ALARM:5 or ALARM:9 within 1 mm; then swapped back"},
      {true, "emergency stop while it jogs, then released", "it stands, and stands on; ALARM:6 with --supply"},
      {true, "the program ten times without a person", "`done` ten times, no ALARM"},
      {true, "the bench's plan", "`BENCH.md` of the project: every line is within what `RISKS.md` says"},
  };
  for (const Check& check : checks)
    if (check.applies) text += fmt::format("| {} | {} | | | |\n", check.what, check.seen);
  return text;
}

}  // namespace lake::actuator
