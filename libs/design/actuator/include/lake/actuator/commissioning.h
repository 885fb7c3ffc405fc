// What a laboratory needs beside a sketch before anything moves: the wiring drawn with this firmware's pins, and a
// sheet on which each check before the first motion is signed.
#pragma once

#include <string>

#include "lake/actuator/firmware.h"

namespace lake::actuator {

// The schematic as SVG: board, bridge, actuator, end stops and whatever of sensors and relay is wired, with
// fuse, emergency stop and pull-down resistors.
std::string SchematicSvg(const FirmwareOptions& options);

// As Markdown: what is checked in which order, what must be seen, and room for name, date and the value that was found.
std::string SignOffSheet(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                         const FirmwareOptions& options);

}  // namespace lake::actuator
