// Linkage and stroke program as the sample study's redesign (data/sts-study) has them, rounded to 1 nm and 1 um: 35 s,
// a little back and then up to standing, most of the way at 5 mm/s.
#pragma once

#include "lake/linkage/design_file.h"

namespace lake {

inline linkage::Design SampleDesign() {
  linkage::Design design;
  design.links = {.l1 = 59.893867, .l2 = 65.559268, .l3 = 50, .l4 = 65.559268, .l5 = 58.509963, .l6 = 299.905069};
  design.d_min_mm = 242;
  design.d_max_mm = 360.756933;
  design.program.emplace().kind = linkage::StrokeProgram::Kind::kFree;
  design.program->knots = {{0, 291.523},     {1.75, 291.533},  {3.5, 291.568},   {5.25, 291.551},  {7, 291.575},
                           {8.75, 290.724},  {10.5, 288.45},   {12.25, 286.571}, {14, 285.099},    {15.75, 291.264},
                           {17.5, 300.014},  {19.25, 308.764}, {21, 317.514},    {22.75, 326.264}, {24.5, 335.014},
                           {26.25, 343.764}, {28, 352.514},    {29.75, 357.963}, {31.5, 360.49},   {33.25, 360.756},
                           {35, 360.756}};
  return design;
}

}  // namespace lake
