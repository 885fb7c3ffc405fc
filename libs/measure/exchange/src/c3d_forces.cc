// The force plates of C3D files.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "c3d_bytes.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/point_recording.h"
#include "readers.h"

namespace lake::exchange {
namespace {

// The analogue channels: every sample of a frame has one value of each.
struct AnalogLayout {
  std::size_t channels = 0, samples = 0;  // of each frame
  std::vector<double> scale, offset;      // of each channel: (stored − offset) × scale
  bool is_unsigned = false;               // 16-bit words without a sign
};

AnalogLayout ReadAnalogLayout(const C3dParameters& parameters, const C3dLayout& layout, const std::string& path) {
  AnalogLayout analog;
  analog.channels = parameters.Count("ANALOG:USED").value_or(0);
  if (analog.channels == 0 || layout.analog_per_frame == 0 || layout.analog_per_frame % analog.channels != 0)
    throw Fail("{}: no analogue channels, and so no forces; export it with its plates' channels, or the forces as .mot",
               path);
  analog.samples = layout.analog_per_frame / analog.channels;
  analog.scale = parameters.Numbers("ANALOG:SCALE");
  analog.offset = parameters.Numbers("ANALOG:OFFSET");
  if (analog.scale.size() < analog.channels || analog.offset.size() < analog.channels)
    throw Fail("{}: ANALOG:SCALE or OFFSET has fewer values than the {} channels", path, analog.channels);
  const double general = parameters.Number("ANALOG:GEN_SCALE").value_or(1);
  for (double& scale : analog.scale) scale *= general;
  const std::vector<std::string> format = parameters.Texts("ANALOG:FORMAT");
  analog.is_unsigned = !format.empty() && Lower(format[0]) == "unsigned";
  if (analog.is_unsigned)
    for (double& offset : analog.offset) offset = Unsigned(offset);
  return analog;
}

// A force along an axis of the plate that a channel measures, and where: x and y in units of the sensors' distances
// from the plate's middle (ORIGIN of types 3, 6 and 7).
struct Sensor {
  std::string_view name;
  int axis;
  double x, y;
};
constexpr Sensor kKistler[] = {{"fx12", 0, 0, 1}, {"fx34", 0, 0, -1}, {"fy14", 1, 1, 0},  {"fy23", 1, -1, 0},
                               {"fz1", 2, 1, 1},  {"fz2", 2, -1, 1},  {"fz3", 2, -1, -1}, {"fz4", 2, 1, -1}};
constexpr Sensor kFourPosts[] = {{"fx1", 0, 1, 1}, {"fx2", 0, -1, 1}, {"fx3", 0, -1, -1}, {"fx4", 0, 1, -1},
                                 {"fy1", 1, 1, 1}, {"fy2", 1, -1, 1}, {"fy3", 1, -1, -1}, {"fy4", 1, 1, -1},
                                 {"fz1", 2, 1, 1}, {"fz2", 2, -1, 1}, {"fz3", 2, -1, -1}, {"fz4", 2, 1, -1}};

// The types that are read: 1 to 4 of the user guide, 5 to 7 of Visual3D's documents.
struct PlateType {
  double type;
  std::size_t channels;
  std::span<const Sensor> sensors = {};  // none: three forces and three moments are measured
  bool has_matrix = false;               // CAL_MATRIX makes those of the channels; type 6 may have none
};
const PlateType kPlateTypes[] = {{1, 6},  // whose moments are where the force acts, x and y, and the free moment
                                 {2, 6},           {3, 8, kKistler},          {4, 6, {}, true},
                                 {5, 8, {}, true}, {6, 12, kFourPosts, true}, {7, 8, kKistler, true}};

// A plate: its channels (from 0), where it lies, and what makes forces and moments of its channels.
struct C3dPlate {
  std::vector<std::size_t> channel;
  Eigen::Matrix3d lab_from_plate;
  Eigen::Vector3d origin_m;           // of its moments, in the laboratory
  Eigen::Vector3d below_m;            // from the middle of its surface to the origin, in its own axes
  Eigen::Vector2d half_m;             // of its sides
  Eigen::MatrixXd six_from_channels;  // N, N m
  Eigen::MatrixXd six_by_posts;       // of type 6, whose documents differ in the order: Fx1 Fy1 Fz1 Fx2, not Fx1 Fx2
  std::optional<double> m_per_place;  // of type 1: where the force acts, metres per unit
};

// Of a text such as N, kN, Nmm, N.m.
double NewtonsPerUnit(const std::string& unit) {
  const std::string name = Lower(unit);
  return (name.starts_with("kn") ? 1000 : 1) * (name.ends_with("mm") ? 1e-3 : name.ends_with("cm") ? 1e-2 : 1);
}

// The order of the sensors' channels where their names say it, as some writers have Fz1 to Fz4 first.
void SortByNames(const std::vector<std::string>& labels, std::span<const Sensor> sensors,
                 std::vector<std::size_t>& channels) {
  std::vector<std::size_t> sorted;
  for (const Sensor& sensor : sensors)
    for (const std::size_t channel : channels)
      if (channel < labels.size() && Lower(labels[channel]).find(sensor.name) != std::string::npos)
        sorted.push_back(channel);
  if (std::is_permutation(sorted.begin(), sorted.end(), channels.begin(), channels.end())) channels = sorted;
}

Eigen::MatrixXd SensorMatrix(std::span<const Sensor> sensors, double a_m, double b_m) {
  Eigen::MatrixXd six(6, static_cast<Eigen::Index>(sensors.size()));
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const Eigen::Vector3d force = Eigen::Vector3d::Unit(sensors[i].axis), at(sensors[i].x * a_m, sensors[i].y * b_m, 0);
    six.col(static_cast<Eigen::Index>(i)) << force, at.cross(force);
  }
  return six;
}

C3dPlate ReadPlate(const C3dParameters& parameters, const C3dLayout& layout, const AnalogLayout& analog,
                   std::size_t index, const std::string& path) {
  // An array has room for the plate that needs most, and perhaps for plates that are not used.
  const std::size_t plates = parameters.Numbers("FORCE_PLATFORM:TYPE").size();
  const auto numbers = [&](const char* name, std::size_t of_each) {
    const std::vector<double> all = parameters.Numbers(fmt::format("FORCE_PLATFORM:{}", name));
    const std::size_t begin = index * std::max(of_each, all.size() / plates);
    if (all.size() < begin + of_each)
      throw Fail("{}: FORCE_PLATFORM:{} has {} values, too few for plate {}", path, name, all.size(), index + 1);
    return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(begin),
                               all.begin() + static_cast<std::ptrdiff_t>(begin + of_each));
  };
  const double number = numbers("TYPE", 1)[0];
  const auto* type = std::ranges::find(kPlateTypes, number, &PlateType::type);
  if (type == std::end(kPlateTypes))
    throw Fail(
        "{}: force plate {} is of type {}, and types 1 to 7 are those that are publicly described, and read: export "
        "its forces as type 2 (three forces and three moments), or as a .mot of OpenSim",
        path, index + 1, number);
  C3dPlate plate;
  for (const double channel : numbers("CHANNEL", type->channels)) {
    if (!(channel >= 1 && channel <= static_cast<double>(analog.channels)))
      throw Fail("{}: force plate {} names channel {}, but there are {}", path, index + 1, channel, analog.channels);
    plate.channel.push_back(static_cast<std::size_t>(channel) - 1);
  }
  const std::vector<std::string> units = parameters.Texts("ANALOG:UNITS");
  const auto unit = [&](std::size_t i) { return plate.channel[i] < units.size() ? units[plate.channel[i]] : ""; };
  // Motion Analysis leaves it out where channels are in N.
  const std::size_t in_matrix = parameters.Numbers("FORCE_PLATFORM:CAL_MATRIX").size() / plates;
  const bool is_needed = number == 5 || (number != 6 && !Lower(unit(0)).starts_with("n")),
             has_matrix = type->has_matrix && (in_matrix > 0 || is_needed);
  if (!has_matrix) SortByNames(parameters.Texts("ANALOG:LABELS"), type->sensors, plate.channel);
  const double m_per_unit = layout.mm_per_unit / kMmPerM;
  const std::vector<double> corners = numbers("CORNERS", 12);
  const auto corner = [&](std::size_t i) { return Eigen::Vector3d(&corners[3 * i]); };
  // Seen in the plate's axes the corners are (+,+), (−,+), (−,−), (+,−).
  const Eigen::Vector3d along_x = (corner(0) + corner(3) - corner(1) - corner(2)) / 2,
                        along_y = (corner(0) + corner(1) - corner(2) - corner(3)) / 2;
  const Eigen::Vector3d x = along_x.normalized(), z = x.cross(along_y).normalized();
  plate.lab_from_plate << x, z.cross(x), z;
  if (!(plate.lab_from_plate.determinant() > 0.5))  // 1 of a plate; a vector of no length stays one
    throw Fail("{}: force plate {} has no corners, or they lie in one line", path, index + 1);
  plate.half_m = m_per_unit / 2 * Eigen::Vector2d(along_x.norm(), along_y.norm());
  const std::vector<double> origin = numbers("ORIGIN", 3);
  // From the middle of the surface to the origin, which lies below it; some writers have the opposite sign. With
  // sensors, x and y are their distances from the middle, or of type 6, where they are 0, the plate's corners.
  Eigen::Vector3d below(origin.data());
  const Eigen::Vector2d given_m = m_per_unit * below.head<2>().cwiseAbs(),
                        sensors_m = given_m.minCoeff() > 0 ? given_m : plate.half_m;
  if (!type->sensors.empty()) below.head<2>().setZero();
  if (number == 1) below.setZero();
  const Eigen::Vector3d up = Eigen::Vector3d::Unit(layout.up_axis - 'x');
  if (up.dot(plate.lab_from_plate * below) > 0) below = -below;
  plate.below_m = m_per_unit * below;
  plate.origin_m =
      m_per_unit * (corner(0) + corner(1) + corner(2) + corner(3)) / 4 + plate.lab_from_plate * plate.below_m;
  const std::size_t outputs = type->sensors.empty() ? 6 : type->channels;
  Eigen::VectorXd newtons(outputs);
  for (std::size_t i = 0; i < outputs; ++i) newtons[static_cast<Eigen::Index>(i)] = NewtonsPerUnit(unit(i));
  if (number == 1) {
    plate.m_per_place = FindMmPerUnit(unit(3)).value_or(layout.mm_per_unit) / kMmPerM;
    newtons[3] = newtons[4] = 1;
  }
  // The user guide has channels in V, and the matrix makes N and N times the file's unit of length of them.
  for (std::size_t i = 3; has_matrix && i < 6 && type->sensors.empty(); ++i)
    if (!Lower(unit(i)).ends_with("m")) newtons[static_cast<Eigen::Index>(i)] *= m_per_unit;
  Eigen::MatrixXd six = newtons.asDiagonal(), matrix = Eigen::MatrixXd::Identity(outputs, type->channels);
  if (has_matrix) {
    const auto rows = std::max(outputs, static_cast<std::size_t>(std::sqrt(in_matrix)));  // 8 of 8 x 8, 6 of 6 x 8
    const std::vector<double> stored = numbers("CAL_MATRIX", rows * type->channels);      // by columns
    matrix = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
        stored.data(), matrix.rows(), matrix.cols(), Eigen::OuterStride<>(static_cast<Eigen::Index>(rows)));
  }
  if (!type->sensors.empty()) six = SensorMatrix(type->sensors, sensors_m.x(), sensors_m.y()) * six;
  plate.six_from_channels = six * matrix;
  if (number == 6) {
    Eigen::MatrixXd by_posts = six;
    for (Eigen::Index i = 0; i < 12; ++i) by_posts.col(3 * (i % 4) + i / 4) = six.col(i);
    plate.six_by_posts = by_posts * matrix;
  }
  return plate;
}

// A plate and what it measured: forces and moments in its own axes, one column a sample.
struct PlateSamples {
  C3dPlate plate;
  Eigen::Matrix<double, 6, Eigen::Dynamic> six;

  Eigen::RowVectorXd Along(int axis) const { return plate.lab_from_plate.row(axis) * six.topRows<3>(); }
};

PlateSamples ReadSamples(const C3dBytes& bytes, const C3dLayout& layout, const AnalogLayout& analog,
                         const C3dPlate& plate) {
  const auto value = [&](std::size_t frame, std::size_t sample, std::size_t channel) {
    const std::size_t at = layout.data_offset + frame * layout.FrameBytes() +
                           layout.WordBytes() * (4 * layout.points + sample * analog.channels + channel);
    const double stored = layout.IsFloat()     ? bytes.Float(at)
                          : analog.is_unsigned ? bytes.Unsigned16(at)
                                               : bytes.Signed16(at);
    return (stored - analog.offset[channel]) * analog.scale[channel];
  };
  PlateSamples read{plate, {}};
  Eigen::MatrixXd channels(plate.channel.size(), layout.frames * analog.samples);
  Eigen::Index column = 0;
  for (std::size_t frame = 0; frame < layout.frames; ++frame)
    for (std::size_t sample = 0; sample < analog.samples; ++sample, ++column)
      for (std::size_t i = 0; i < plate.channel.size(); ++i)
        channels(static_cast<Eigen::Index>(i), column) = value(frame, sample, plate.channel[i]);
  read.six = plate.six_from_channels * channels;
  // A force on the ground is more vertical than horizontal.
  if (plate.six_by_posts.size() > 0 && read.six.row(2).cwiseAbs().sum() < read.six.topRows<2>().colwise().norm().sum())
    read.six = plate.six_by_posts * channels;
  if (plate.m_per_place)  // the moment of the force where it acts on the surface, and the free moment
    for (Eigen::Index i = 0; i < read.six.cols(); ++i) {
      const Eigen::Vector3d at_m(*plate.m_per_place * read.six(3, i), *plate.m_per_place * read.six(4, i), 0);
      const Eigen::Vector3d moment_nm = at_m.cross(read.six.col(i).head<3>()) + Eigen::Vector3d(0, 0, read.six(5, i));
      read.six.col(i).tail<3>() = moment_nm.allFinite() ? moment_nm : Eigen::Vector3d::Zero();
    }
  return read;
}

constexpr double kLoaded_n = 20;  // less is a plate's noise

// Of the samples in which the plate is loaded, the share in which the force acts on it (or 3 cm beside it, where a shoe
// reaches over its edge), with the moments multiplied by `factor`; 1 of a plate that is never loaded.
double ShareOnPlate(const PlateSamples& plate, double factor) {
  constexpr double kMargin_m = 0.03;
  Eigen::Index loaded = 0, on_plate = 0;
  for (Eigen::Index i = 0; i < plate.six.cols(); ++i) {
    const Eigen::Vector3d force_n = plate.six.col(i).head<3>(),
                          moment_nm = factor * plate.six.col(i).tail<3>() + plate.plate.below_m.cross(force_n);
    if (std::abs(force_n.z()) < kLoaded_n) continue;
    const Eigen::Vector2d at_m = Eigen::Vector2d(-moment_nm.y(), moment_nm.x()) / force_n.z();
    ++loaded;
    on_plate += ((at_m.cwiseAbs() - plate.plate.half_m).maxCoeff() <= kMargin_m) ? 1 : 0;
  }
  return loaded ? static_cast<double>(on_plate) / static_cast<double>(loaded) : 1;
}

// The centre of pressure shows whether the moments are in the unit that the file says, or in none if it says none.
void CheckCentreOfPressure(PlateSamples& plate, const std::string& name, std::vector<std::string>& warnings) {
  constexpr double kMostly = 0.9, kHalf = 0.5;
  const double share = ShareOnPlate(plate, 1);
  if (share >= kHalf) return;
  for (const double factor : {1e-3, 1e3})
    if (ShareOnPlate(plate, factor) >= kMostly) {
      plate.six.bottomRows<3>() *= factor;
      warnings.push_back(fmt::format("{}: its moments are taken to be in {}, as the force acts on the plate then", name,
                                     factor < 1 ? "N mm" : "kN m"));
      return;
    }
  warnings.push_back(fmt::format(
      "{}: in {:.0f} % of the samples with load the force acts beyond its edges: are CORNERS, ORIGIN and the "
      "units of its channels right?",
      name, 100 * (1 - share)));
}

// What a plate measures while nobody stands on it, and where this comes from, for the message.
struct Baseline {
  Eigen::Matrix<double, 6, 1> six = Eigen::Matrix<double, 6, 1>::Zero();
  std::string source;
};

// Of FORCE_PLATFORM:ZERO, from 0 and the one behind the last; nullopt if it names none that the file holds. Its frames
// count as those of the points do; where they are not among them, from the first one stored.
std::optional<std::array<std::size_t, 2>> ZeroFrames(const C3dParameters& parameters, const C3dLayout& layout) {
  const std::vector<double> zero = parameters.Numbers("FORCE_PLATFORM:ZERO");
  if (zero.size() < 2) return std::nullopt;
  const double from = Unsigned(zero[0]), to = Unsigned(zero[1]), frames = static_cast<double>(layout.frames);
  if (!(from >= 1 && to >= from)) return std::nullopt;
  const auto first = static_cast<double>(layout.first_frame);
  const double before = from >= first && to < first + frames ? first : 1;
  if (to - before >= frames) return std::nullopt;
  return std::array{static_cast<std::size_t>(from - before), static_cast<std::size_t>(to - before) + 1};
}

// The mean of the windows in which the vertical force is steady and small against the `most` that a plate of the file
// bears: a foot at rest bears more than a tenth of it.
std::optional<Baseline> BaselineWithoutContact(const PlateSamples& plate, int up, double most_n, double rate_hz) {
  constexpr double kWindow_s = 0.1, kEmpty = 0.1, kSteady = 0.01, kAlike = 0.02;
  constexpr Eigen::Index kLeastSamples = 10, kLeastWindows = 2;
  const Eigen::RowVectorXd vertical_n = plate.Along(up);
  const Eigen::Index length = std::max(kLeastSamples, static_cast<Eigen::Index>(std::lround(kWindow_s * rate_hz)));
  std::vector<std::pair<double, Eigen::Index>> quiet;  // mean, first sample
  for (Eigen::Index i = 0; i + length <= vertical_n.size(); i += length) {
    const auto window = vertical_n.segment(i, length).array();
    const double mean = window.mean(), sd = std::sqrt((window - mean).square().mean());
    if (std::abs(mean) <= kEmpty * most_n && sd <= kSteady * most_n) quiet.emplace_back(mean, i);
  }
  if (quiet.empty()) return std::nullopt;
  std::sort(quiet.begin(), quiet.end());
  const double level_n = quiet[quiet.size() / 2].first;
  std::erase_if(quiet, [&](const auto& window) { return std::abs(window.first - level_n) > kAlike * most_n; });
  if (static_cast<Eigen::Index>(quiet.size()) < kLeastWindows) return std::nullopt;
  Baseline baseline;
  for (const auto& window : quiet) baseline.six += plate.six.middleCols(window.second, length).rowwise().mean();
  baseline.six /= static_cast<double>(quiet.size());
  baseline.source =
      fmt::format("its mean over {} s without contact; FORCE_PLATFORM:ZERO names no frames",
                  SignificantText(static_cast<double>(static_cast<Eigen::Index>(quiet.size()) * length) / rate_hz, 2));
  return baseline;
}

// Subtracts what each plate measures while it is empty: in the frames that the file names, else in those without
// contact.
void SubtractBaselines(const C3dParameters& parameters, const C3dLayout& layout, std::size_t samples,
                       const std::string& path, std::vector<std::optional<PlateSamples>>& plates,
                       std::vector<std::string>& warnings) {
  constexpr double kNamedEmpty = 0.2, kLeast_n = 50, kSaid_n = 1;
  const int up = layout.up_axis - 'x';
  double most_n = 0;
  for (const auto& plate : plates)
    if (plate && plate->six.cols() > 0) most_n = std::max(most_n, plate->Along(up).cwiseAbs().maxCoeff());
  const auto named = ZeroFrames(parameters, layout);
  for (std::size_t index = 0; index < plates.size(); ++index) {
    if (!plates[index]) continue;
    PlateSamples& plate = *plates[index];
    std::optional<Baseline> baseline;
    if (named) {
      const auto [begin, end] = std::array{static_cast<Eigen::Index>((*named)[0] * samples),
                                           static_cast<Eigen::Index>((*named)[1] * samples)};
      const std::string frames =
          fmt::format("frames {} to {}", layout.first_frame + (*named)[0], layout.first_frame + (*named)[1] - 1);
      baseline = Baseline{plate.six.middleCols(begin, end - begin).rowwise().mean(),
                          fmt::format("its mean in {}, which FORCE_PLATFORM:ZERO names", frames)};
      const double load_n = std::abs(plate.plate.lab_from_plate.row(up).dot(baseline->six.head<3>()));
      if (load_n > std::max(kNamedEmpty * most_n, kLeast_n)) {
        warnings.push_back(
            fmt::format("{}: force plate {} bears {} N in {}, which FORCE_PLATFORM:ZERO names as those without "
                        "contact; no offset is subtracted",
                        path, index + 1, SignificantText(load_n, 3), frames));
        continue;
      }
    } else {
      baseline = BaselineWithoutContact(plate, up, most_n, static_cast<double>(samples) * layout.rate_hz);
    }
    if (!baseline) continue;
    plate.six.colwise() -= baseline->six;
    if (const double offset_n = baseline->six.head<3>().norm(); offset_n >= kSaid_n)
      warnings.push_back(fmt::format("{}: force plate {}: an offset of {} N is subtracted, {}", path, index + 1,
                                     SignificantText(offset_n, 3), baseline->source));
  }
}

// In the laboratory's axes, as the ground's push on the foot.
void TurnIntoLaboratory(const PlateSamples& samples, int up, PlateForces& plate) {
  const Eigen::Matrix3Xd force_n = samples.plate.lab_from_plate * samples.six.topRows<3>(),
                         moment_nm = samples.plate.lab_from_plate * samples.six.bottomRows<3>();
  const double sign = force_n.row(up).sum() < 0 ? -1 : 1;
  for (Eigen::Index i = 0; i < force_n.cols(); ++i) {
    plate.force_n.emplace_back(sign * force_n.col(i));
    plate.moment_nm.emplace_back(sign * moment_nm.col(i));
    plate.point_m.push_back(samples.plate.origin_m);
  }
}

}  // namespace

GroundForceRecording ReadC3dForces(const std::filesystem::path& path) {
  const C3dBytes bytes(ReadTextFile(path), path.string());
  const C3dParameters parameters(bytes);
  const C3dLayout layout = ReadLayout(bytes, parameters);
  const std::size_t count =
      std::min(parameters.Count("FORCE_PLATFORM:USED").value_or(0), parameters.Numbers("FORCE_PLATFORM:TYPE").size());
  if (count == 0)
    throw Fail("{}: no force plates (FORCE_PLATFORM:USED); export it with them, or the forces as .mot", path.string());
  const AnalogLayout analog = ReadAnalogLayout(parameters, layout, path.string());
  GroundForceRecording forces;
  forces.up_axis = layout.up_axis;
  forces.warnings = layout.warnings;
  for (std::size_t frame = 0; frame < layout.frames; ++frame)
    for (std::size_t sample = 0; sample < analog.samples; ++sample)
      forces.time_s.push_back((static_cast<double>(layout.first_frame - 1 + frame) +
                               static_cast<double>(sample) / static_cast<double>(analog.samples)) /
                              layout.rate_hz);
  std::vector<std::optional<PlateSamples>> plates;
  for (std::size_t index = 0; index < count; ++index) {
    PlateForces& plate = forces.plates.emplace_back();
    plate.name = fmt::format("plate {}", index + 1);
    try {
      plates.emplace_back(
          ReadSamples(bytes, layout, analog, ReadPlate(parameters, layout, analog, index, path.string())));
    } catch (const Error& error) {
      plates.emplace_back();
      plate.unusable = error.what();
      forces.warnings.push_back(fmt::format("{}; it is left out", error.what()));
    }
  }
  if (std::none_of(plates.begin(), plates.end(), [](const auto& plate) { return plate.has_value(); }))
    throw Fail("{}", forces.plates.front().unusable);
  SubtractBaselines(parameters, layout, analog.samples, path.string(), plates, forces.warnings);
  const std::vector<Eigen::Vector3d> nothing(forces.time_s.size(), Eigen::Vector3d::Zero());
  for (std::size_t index = 0; index < count; ++index) {
    PlateForces& plate = forces.plates[index];
    if (!plates[index]) {
      plate.force_n = plate.point_m = plate.moment_nm = nothing;
      continue;
    }
    CheckCentreOfPressure(*plates[index], fmt::format("{}: force {}", path.string(), plate.name), forces.warnings);
    TurnIntoLaboratory(*plates[index], layout.up_axis - 'x', plate);
  }
  return forces;
}

}  // namespace lake::exchange
