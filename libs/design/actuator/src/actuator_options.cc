// The options of a stroke program, its firmware and a duty table.
#include <map>

#include "homing.h"
#include "lake/actuator/duty_calibration.h"
#include "lake/core/error.h"

namespace lake::actuator {

void Describe(ScheduleOptions& o, OptionList& options) {
  options.Add("speed", o.speed_mm_s, "Constant speed instead of the design's program").Unit("mm/s").Between(0.01, 1000);
  options.Add("from-angle", o.from_deg, "Constant program: knee angle at its start")
      .Unit("degrees")
      .Key("from_deg")
      .Between(0, 360)
      .Otherwise("at d_min");
  options.Add("to-angle", o.to_deg, "Constant program: knee angle at its end")
      .Unit("degrees")
      .Key("to_deg")
      .Between(0, 360)
      .Otherwise("standing");
  options.Add("return", o.return_trip, "Then return to the start the same way");
  options
      .Add("smooth", o.smooth_mm,
           "How far the program may move when reversals within the actuator's play are removed; 0: as it is")
      .Unit("mm")
      .Between(0, 5);
  options.Add("hold", o.hold_s, "Pause before returning (with --return)").Unit("s").Between(0, 3600);
  options.Add("margin", o.margin_mm, "Margin of stroke kept before standing and before the linkage's ends")
      .Unit("mm")
      .Between(0, 1000);
  options.Add("max-speed", o.max_speed_mm_s, "Speed limit of the actuator").Unit("mm/s").Between(0.001, 1000);
  options.Add("max-acceleration", o.max_acceleration_mm_s2, "Acceleration limit of the actuator")
      .Unit("mm/s²")
      .Between(0.001, 1e6)
      .Otherwise("speeds change at once");
  options.Add("dead-time", o.dead_time_s, "Braking time before a reversal").Unit("s").Between(kLeastDeadTime_s, 5);
}

void Describe(FirmwareOptions& o, OptionList& options) {
  options.Add("home-stroke", o.home_stroke_mm, "Stroke at which the retract end stop acts; 0: the lower soft limit")
      .Unit("mm")
      .Between(0, kMostStroke_mm);
  options.Add("home-speed", o.home_speed_mm_s, "Homing speed, limited by the duty table")
      .Unit("mm/s")
      .Between(0.001, 1000);
  options.Add("command-timeout", o.command_timeout_s, "Stop after the host has been silent this long; 0: never")
      .Unit("s")
      .Between(0, 60);
  options
      .Add("speed-tolerance", o.speed_tolerance_percent,
           "How far speeds may differ from the duty table: part of the drift bound")
      .Unit("percent")
      .Between(0, 100)
      .Otherwise("the table's tolerance_percent, else 10");
  options.Add("home-error", o.home_error_mm, "How well the stroke is known after homing: part of the drift bound")
      .Unit("mm")
      .Between(0, 10);
  options.Add("lag", o.lag_s, "Time by which the speed may lag behind the duty: part of the drift bound")
      .Unit("s")
      .Between(0, 0.5);
  options
      .Add("stop-travel", o.stop_travel_mm, "Travel within which an end stop must release when the actuator moves away")
      .Unit("mm")
      .Between(0.1, 10)
      .Otherwise("2");
  options
      .Add("extend-stop", o.extend_stop_mm, "Distance of the extend end stop before the linkage's end; 0: no such stop")
      .Unit("mm")
      .Between(0, 100);
  options.Add("accept-drift", o.accept_drift,
              "For a bench without a person: write a program whose drift may pass the linkage's end");
  options.AddChoice("feedback", o.feedback,
                    OptionList::Choices<Feedback>{{"none", Feedback::kNone}, {"pot", Feedback::kPotentiometer}},
                    "What measures the stroke: a potentiometer on A0 closes the loop");
  const auto set_scale = [&o](const OptionTexts& texts, const std::string&) {
    std::string text;  // a list in a file has its parts apart
    for (const std::string& part : texts) text += (text.empty() ? "" : ",") + part;
    o.potentiometer = ParsePotentiometerScale(text);
  };
  options
      .AddCustom("pot", "Two readings of the potentiometer with their strokes, as lake-stroke calibrate has them",
                 set_scale)
      .Value("COUNTS=MM,COUNTS=MM");
  options.Add("feedback-error", o.feedback_error_mm, "By which the potentiometer's stroke may be off")
      .Unit("mm")
      .Between(0, 10);
  options.Add("supply", o.supply_v, "Voltage of the motor's supply, watched on A2; 0: not wired")
      .Value("VOLT")
      .Key("supply_v");
  options.Add("current-sense", o.current_sense, "The motor's current is measured on A1 (ACS712-05B)");
  options.Add("current-zero", o.current_zero_v, "What the current sensor gives without current")
      .Value("VOLT")
      .Key("current_zero_v")
      .Between(0, 4);
  options.Add("current-scale", o.current_v_per_a, "What it gives per ampere")
      .Value("VOLT_PER_AMPERE")
      .Key("current_v_per_a")
      .Between(0.01, 5);
  options.Add("max-current", o.max_current_a, "More is a short: the bridge goes off at once")
      .Value("AMPERE")
      .Key("max_current_a")
      .Positive();
  options.Add("stall-current", o.stall_current_a, "More for 0.3 s is a stall")
      .Value("AMPERE")
      .Key("stall_current_a")
      .Positive();
  options
      .Add("force-limit", o.force_limit_n,
           "Largest force of the actuator, held by its current; more for 0.3 s is a stall")
      .Unit("N")
      .Between(0.001, 10'000)
      .Otherwise("--stall-current alone");
  options.Add("force-per-ampere", o.force_n_per_a, "The actuator's force per ampere beyond its idle current")
      .Value("N_PER_AMPERE")
      .Key("force_n_per_a");
  options.Add("idle-current", o.idle_a, "What the motor takes without a load")
      .Value("AMPERE")
      .Key("idle_a")
      .NotNegative();
  options.Add("speed-limit", o.speed_limit_mm_s, "A faster program is refused, and the closed loop is never faster")
      .Unit("mm/s")
      .Between(0.001, 1000)
      .Otherwise("the duty table's last");
  options.Add("bridge-sense", o.bridge_sense,
              "The bridge's outputs are read back on A3 and A4, each through a divider: then a stop may brake");
  options.Add("safety-relay", o.pins.safety_relay, "Pin of a relay in the motor's supply, before the sense of --supply")
      .Value("PIN");
  options.Add("hold-button", o.pins.hold_button, "Pin of a button to ground: released, whatever moves is stopped")
      .Value("PIN");
  const auto set_pins = [&o](const OptionTexts& texts, const std::string& said) {
    static const std::map<std::string, int Pins::*> kPins = {
        {"ena", &Pins::ena},       {"in1", &Pins::in1},   {"in2", &Pins::in2},  {"retract", &Pins::retract},
        {"extend", &Pins::extend}, {"out1", &Pins::out1}, {"out2", &Pins::out2}};
    for (const auto& [name, pin] : NamesAndValues(texts, said)) {
      const auto found = kPins.find(name);
      if (found == kPins.end())
        throw UsageError("--pins '{}': one of ena, in1, in2, retract, extend, out1, out2 and a number, as ena=10",
                         name);
      o.pins.*(found->second) = OptionValue<int>::Parse(pin, said + " " + name);
    }
  };
  options.AddCustom("pins", "Other pins than D9, D7, D8 of the bridge and D2, D3 of the end stops", set_pins)
      .SplitAtCommas()
      .Value("NAME=PIN,NAME=PIN");
  options.Add("table-tolerance", o.table_tolerance_mm, "Stroke error allowed to fit a long program into the flash")
      .Unit("mm")
      .Between(1e-6, 10);
  options.Check([&o](const OptionList&) { o.Check(); });
}

void Describe(CalibrateOptions& o, OptionList& options) {
  options.Add("settle", o.settle_s, "Time ignored at the start of each plateau").Unit("s").Between(0, 60);
  options.Add("min-plateau", o.min_plateau_s, "Shortest plateau of constant duty").Unit("s").Between(0, 600);
  options.Add("still", o.still_mm_s, "Speed below which the actuator counts as standing still")
      .Unit("mm/s")
      .Between(1e-6, 10);
  options.Add("steady", o.steady_fraction, "How much the speeds of a plateau's halves may differ, as a fraction")
      .Between(1e-6, 1);
  options.Check([&o](const OptionList&) { o.Check(); });
}

}  // namespace lake::actuator
