// Force plates of C3D files: floats and integers, both orders of bytes, calibration matrices, either sign; and files
// that contradict themselves.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "c3d_maker.h"
#include "lake/core/atomic_file.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/ground_forces.h"
#include "places.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;
using Six = Eigen::Matrix<double, 6, 1>;

// What stands on the plate: a force on the foot in the laboratory (x right, y forward, z up) where it acts.
const Eigen::Vector3d kForce_n(10, -20, 700), kActsAt_m(1.05, 0.45, 0), kOrigin_m(1, 0.5, -0.04);
const Eigen::Vector3d kMoment_nm = (kActsAt_m - kOrigin_m).cross(kForce_n);

struct PlateFile {
  bool is_mips = false, is_integer = false, is_unsigned = false;
  int type = 2;
  double sign = 1;         // −1: the force on the plate
  double origin_sign = 1;  // −1: from the origin to the surface
  std::string units = "Nmm";
  Eigen::Matrix<double, 6, 6> calibration = Eigen::Matrix<double, 6, 6>::Identity();
  std::map<std::string, std::vector<double>> instead;  // of parameters, as "FORCE_PLATFORM:TYPE"
  std::vector<std::string> without;
  int frames = 3, samples = 2, empty_frames = 0;    // the first of them without anyone on the plate
  Six offset = Six::Zero();                         // of an empty plate's channels
  std::vector<double> zero = {};                    // FORCE_PLATFORM:ZERO; empty: not there
  int plates = 1;                                   // the second names channels that are not there
  std::optional<int> header_points, header_analog;  // what is wrong in the header

  C3dMaker Made() const;
  int Stored(int channel) const { return static_cast<int>(std::lround(Raw()[channel] / Scale() + Offset())); }
  double Scale() const { return is_integer ? 50 : 1; }
  double Offset() const { return is_unsigned ? 40000 : is_integer ? 100 : 0; }
  bool has_word_offset = false;                            // ANALOG:OFFSET as words of 16 bits
  std::vector<double> channels = {};                       // of another type of plate, in every sample
  std::vector<std::string> labels = {}, their_units = {};  // of these
  int points = 1;                                          // 0: forces alone
  std::vector<double> matrix = {};                         // of another type of plate, by columns

  std::size_t Channels() const { return channels.empty() ? 6 : channels.size(); }

 private:
  Six RawOf(int frame) const { return (frame < empty_frames ? Six::Zero() : Raw()) + offset; }
  Six Raw() const {
    // The plate's x is the laboratory's, its y and z look back and down.
    const Eigen::Vector3d turned(1, -1, -1);
    Six six;
    six << turned.cwiseProduct(kForce_n), turned.cwiseProduct(kMoment_nm) * (units == "Nmm" ? 1000 : 1);
    return sign * (calibration.inverse() * six);
  }
};

C3dMaker PlateFile::Made() const {
  C3dMaker made;
  made.processor = is_mips ? 86 : 84;
  made.is_float = !is_integer;
  made.points = points, made.frames = frames, made.first = 11;
  made.channels = static_cast<int>(Channels()), made.samples = samples;
  made.analog = [this](int frame, int channel) {
    return !channels.empty() ? channels[channel] : is_integer ? Stored(channel) : RawOf(frame)[channel];
  };
  made.h_points = header_points, made.h_analog = header_analog;
  made.Fill();
  for (const char* name : {"POINT:FRAMES", "ANALOG:RATE"}) made.Remove(name);
  made.AddTexts("POINT", "Y_SCREEN", {"+Z"}, ' ');
  made.Add("POINT", "LONG_FRAMES", 4, {static_cast<double>(frames)});
  made.Add("ANALOG", "GEN_SCALE", 4, {0.5});
  made.Add("ANALOG", "SCALE", 4, std::vector<double>(Channels(), 2 * Scale()));
  made.Add("ANALOG", "OFFSET", has_word_offset ? 2 : 4, std::vector<double>(Channels(), Offset()));
  if (!labels.empty()) made.AddTexts("ANALOG", "LABELS", labels, ' ');
  const std::vector<std::string> six_units = {"N", "N", "N", units, units, units};
  made.AddTexts("ANALOG", "UNITS", channels.empty() ? six_units : their_units, ' ');
  if (is_unsigned) made.AddTexts("ANALOG", "FORMAT", {"UNSIGNED"}, ' ');
  const auto of_each = [&](const std::string& name, const std::vector<double>& values) {
    std::vector<double> all;
    for (int i = 0; i < plates; ++i) all.insert(all.end(), values.begin(), values.end());
    made.Add("FORCE_PLATFORM", name, 4, all);
  };
  made.Add("FORCE_PLATFORM", "USED", 4, {static_cast<double>(plates)});
  of_each("TYPE", {static_cast<double>(type)});
  std::vector<double> numbers(Channels() * static_cast<std::size_t>(plates));
  std::iota(numbers.begin(), numbers.end(), 1);
  made.Add("FORCE_PLATFORM", "CHANNEL", 4, numbers);
  of_each("CORNERS", {1200, 200, 0, 800, 200, 0, 800, 800, 0, 1200, 800, 0});
  of_each("ORIGIN", {0, 0, origin_sign * 40});
  if (!zero.empty()) made.Add("FORCE_PLATFORM", "ZERO", 4, zero);
  if (type == 4) made.Add("FORCE_PLATFORM", "CAL_MATRIX", 4, {calibration.data(), calibration.data() + 36});
  if (!matrix.empty()) made.Add("FORCE_PLATFORM", "CAL_MATRIX", 4, matrix);
  for (const auto& [name, values] : instead) {
    C3dEntry& entry = *made.Find(name);
    entry.type = 4, entry.numbers = values, entry.dimensions = {static_cast<int>(values.size())};
  }
  for (const std::string& name : without) made.Remove(name);
  return made;
}

// The place of the only point in a frame, mm.
Eigen::Vector3d PointAt(int frame) {
  const C3dMaker made;
  return made.scale * Eigen::Vector3d(made.Stored(0, frame, 0), made.Stored(0, frame, 1), made.Stored(0, frame, 2));
}

class C3dForces : public testing::Test {
 protected:
  std::filesystem::path Write(const PlateFile& file) const {
    WriteTextFile(folder_ / "plate.c3d", file.Made().Bytes());
    return folder_ / "plate.c3d";
  }
  exchange::GroundForceRecording Read(const PlateFile& file) const { return exchange::ReadGroundForces(Write(file)); }
  // `step`: of a stored channel, N or units of moment.
  void ExpectTheForce(const PlateFile& file, double step) const {
    const exchange::GroundForceRecording read = Read(file);
    ASSERT_EQ(read.plates.size(), 1u);
    EXPECT_EQ(read.up_axis, 'z');
    ASSERT_EQ(read.time_s.size(), 6u);
    EXPECT_NEAR(read.time_s.front(), 0.10, 1e-12);  // frame 11 of 100 Hz
    EXPECT_NEAR(read.time_s.back(), 0.125, 1e-12);
    const exchange::PlateForces& plate = read.plates.front();
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_LT((plate.force_n[i] - kForce_n).cwiseAbs().maxCoeff(), 1e-4 + step / 2);
      EXPECT_LT((plate.moment_nm[i] - kMoment_nm).cwiseAbs().maxCoeff(), 1e-4 + step / 2 * 1e-3);
      EXPECT_LT((plate.point_m[i] - kOrigin_m).norm(), 1e-6);
    }
  }
  void ExpectRefused(const PlateFile& file, const std::string& message) const {
    EXPECT_THAT(MessageOf([&] { Read(file); }), testing::AllOf(HasSubstr("plate.c3d"), HasSubstr(message)));
  }
  TemporaryFolder folder_;
};

TEST_F(C3dForces, AreTheForceOnTheFootWhateverTheSignsOfTheFile) {
  for (const double sign : {1.0, -1.0})
    for (const double origin_sign : {1.0, -1.0}) {
      PlateFile file;
      file.sign = sign;
      file.origin_sign = origin_sign;
      ExpectTheForce(file, 0);
    }
  PlateFile newton_metres;
  newton_metres.units = "Nm";
  ExpectTheForce(newton_metres, 0);
}

TEST_F(C3dForces, OfIntegersAndOfTheOtherOrderOfBytes) {
  for (const bool is_mips : {false, true}) {
    PlateFile file;
    file.is_mips = is_mips;
    ExpectTheForce(file, 0);
    file.is_integer = true;
    ExpectTheForce(file, file.Scale());
    const exchange::PointRecording points = exchange::ReadC3d(Write(file));
    ASSERT_EQ(points.time_s.size(), 3u);  // by LONG_FRAMES
    EXPECT_LT((points.points.at(0).positions.at(2) - PointAt(2)).norm(), 1e-4);
    file.is_unsigned = true;
    EXPECT_GT(file.Stored(2), 32767) << "beyond what a signed word holds";
    ExpectTheForce(file, file.Scale());
    file.has_word_offset = true;  // 40000, with a sign −25536
    ExpectTheForce(file, file.Scale());
  }
}

TEST_F(C3dForces, OfTypeFourAreMultipliedWithTheCalibrationByColumns) {
  PlateFile file;
  file.type = 4;
  file.calibration.diagonal().setConstant(2);
  file.calibration(0, 2) = 0.25, file.calibration(4, 1) = -0.5;
  ExpectTheForce(file, 0);
  // In an array whose plates have room for 8 x 8, as beside one of type 7.
  Eigen::Matrix<double, 8, 8> room = Eigen::Matrix<double, 8, 8>::Zero();
  room.topLeftCorner<6, 6>() = file.calibration;
  file.instead["FORCE_PLATFORM:CAL_MATRIX"] = {room.data(), room.data() + 64};
  ExpectTheForce(file, 0);
}

// Arrays may have room for more plates than are used.
TEST_F(C3dForces, OfTheSecondPlateOfTwoInArraysOfThree) {
  PlateFile file;
  file.plates = 3;
  file.frames = 40;
  file.instead["FORCE_PLATFORM:USED"] = {2};
  file.instead["FORCE_PLATFORM:CHANNEL"] = {1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0};
  const exchange::GroundForceRecording read = Read(file);
  ASSERT_EQ(read.plates.size(), 2u);
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  EXPECT_LT((read.plates[1].force_n[0] - kForce_n).norm(), 1e-3);
  EXPECT_LT((read.plates[1].point_m[0] - kOrigin_m).norm(), 1e-6);
}

// Motion Analysis has type 4 with channels in N and a matrix without numbers; of channels in V it is needed.
TEST_F(C3dForces, OfTypeFourInNewtonsNeedNoCalibration) {
  PlateFile file;
  file.type = 4;
  file.instead["FORCE_PLATFORM:CAL_MATRIX"] = {};
  ExpectTheForce(file, 0);
  file.channels = std::vector<double>(6, 1);
  file.their_units = std::vector<std::string>(6, "V");
  ExpectRefused(file, "CAL_MATRIX has 0 values");
}

// Four posts under the plate, each with a force of its own (plate axes: x to the right, y back, z down), 0.2 m beside
// the middle along x, 0.25 m along y and 0.04 m below the surface.
struct Posts {
  static constexpr double kA_m = 0.2, kB_m = 0.25;
  std::array<Eigen::Vector3d, 4> force_n = {Eigen::Vector3d(-10, 3, -250), {5, 1, -180}, {2, -7, -120}, {-4, 2, -90}};

  double Sum(int axis, std::initializer_list<std::size_t> posts) const {
    double sum = 0;
    for (const std::size_t post : posts) sum += force_n[post - 1][axis];
    return sum;
  }
  // About the point in the middle between them, laboratory axes.
  Eigen::Vector3d Moment_nm() const {
    const Eigen::Vector3d turned(1, -1, -1);
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    const double x[] = {kA_m, -kA_m, -kA_m, kA_m}, y[] = {kB_m, kB_m, -kB_m, -kB_m};
    for (std::size_t i = 0; i < 4; ++i)
      moment += turned.cwiseProduct(Eigen::Vector3d(x[i], y[i], 0)).cross(turned.cwiseProduct(force_n[i]));
    return moment;
  }
  Eigen::Vector3d Force_n() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& force : force_n) sum += force.cwiseProduct(Eigen::Vector3d(1, -1, -1));
    return sum;
  }
  // Kistler's channels: Fx12 Fx34 Fy14 Fy23 Fz1 Fz2 Fz3 Fz4.
  std::vector<double> Kistler() const {
    return {Sum(0, {1, 2}), Sum(0, {3, 4}), Sum(1, {1, 4}), Sum(1, {2, 3}),
            Sum(2, {1}),    Sum(2, {2}),    Sum(2, {3}),    Sum(2, {4})};
  }
};

void ExpectForceOf(const Posts& posts, const exchange::GroundForceRecording& read) {
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  EXPECT_LT((read.plates.at(0).force_n[3] - posts.Force_n()).norm(), 1e-3);
  EXPECT_LT((read.plates.at(0).moment_nm[3] - posts.Moment_nm()).norm(), 1e-3);
}

TEST_F(C3dForces, OfKistlersFourPosts) {
  const Posts posts;
  PlateFile file;
  file.type = 3;
  file.channels = posts.Kistler();
  file.their_units = std::vector<std::string>(8, "N");
  for (const double origin_sign : {1.0, -1.0}) {  // of the depth; the distances have no sign
    file.instead["FORCE_PLATFORM:ORIGIN"] = {200, 250, 40 * origin_sign};
    const exchange::GroundForceRecording read = Read(file);
    ExpectForceOf(posts, read);
    EXPECT_LT((read.plates.at(0).point_m[3] - kOrigin_m).norm(), 1e-6);
  }
  // With the vertical forces first, as their names say; in kN.
  std::rotate(file.channels.begin(), file.channels.begin() + 4, file.channels.end());
  for (double& value : file.channels) value /= 1000;
  file.labels = {"Fz1", "Fz2", "Fz3", "Fz4", "Fx12", "Fx34", "Fy14", "Fy23"};
  file.their_units = std::vector<std::string>(8, "kN");
  ExpectForceOf(posts, Read(file));
}

// Documents differ in whether the twelve stand by axes or by posts: by the names, or as the force is upright.
TEST_F(C3dForces, OfTwelveChannelsByAxesOrByPosts) {
  const Posts posts;
  PlateFile by_axes, by_posts;
  by_axes.type = by_posts.type = 6;
  by_axes.their_units = by_posts.their_units = std::vector<std::string>(12, "N");
  by_axes.instead["FORCE_PLATFORM:ORIGIN"] = by_posts.instead["FORCE_PLATFORM:ORIGIN"] = {200, 250, 40};
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t post = 1; post <= 4; ++post) by_axes.channels.push_back(posts.Sum(axis, {post}));
  for (std::size_t post = 1; post <= 4; ++post)
    for (int axis = 0; axis < 3; ++axis) by_posts.channels.push_back(posts.Sum(axis, {post}));
  ExpectForceOf(posts, Read(by_axes));
  ExpectForceOf(posts, Read(by_posts));
  for (const char* post : {"1", "2", "3", "4"})
    for (const char* axis : {"Fx", "Fy", "Fz"}) by_posts.labels.push_back(std::string(axis) + post);
  ExpectForceOf(posts, Read(by_posts));
}

// Type 7 has Kistler's channels and a matrix of 8 × 8; of type 5 one of 6 × 8 makes forces and moments of eight in V,
// in N and N times the file's unit of length.
TEST_F(C3dForces, OfEightChannelsWithACalibration) {
  const Posts posts;
  PlateFile file;
  file.type = 7;
  file.instead["FORCE_PLATFORM:ORIGIN"] = {200, 250, 40};
  file.their_units = std::vector<std::string>(8, "V");
  Eigen::Matrix<double, 8, 8> mixed = 50 * Eigen::Matrix<double, 8, 8>::Identity();
  mixed(0, 4) = 2, mixed(6, 1) = -3;
  const std::vector<double> forces_n = posts.Kistler();
  const Eigen::Matrix<double, 8, 1> volts =
      mixed.inverse() * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(&forces_n[0]);
  file.channels = {volts.data(), volts.data() + 8};
  file.matrix = {mixed.data(), mixed.data() + 64};
  ExpectForceOf(posts, Read(file));

  file.type = 5;
  Eigen::Matrix<double, 6, 8> six;
  six << 1, 1, 0, 0, 0, 0, 0, 0,         // Fx = Fx12 + Fx34
      0, 0, 1, 1, 0, 0, 0, 0,            // Fy
      0, 0, 0, 0, 1, 1, 1, 1,            // Fz
      0, 0, 0, 0, 250, 250, -250, -250,  // Mx, N mm
      0, 0, 0, 0, -200, 200, 200, -200,  // My
      -250, 250, 200, -200, 0, 0, 0, 0;  // Mz
  const Eigen::Matrix<double, 6, 8> of_volts = six * mixed;
  file.matrix = {of_volts.data(), of_volts.data() + 48};
  file.instead["FORCE_PLATFORM:ORIGIN"] = {0, 0, 40};
  ExpectForceOf(posts, Read(file));
}

TEST_F(C3dForces, WithTheCentreOfPressureAndTheFreeMoment) {
  PlateFile file;
  file.type = 1;  // x is the laboratory's, y and z are turned; the middle of the surface is at (1, 0.5, 0) m
  const double free_nm = 3;
  file.channels = {kForce_n.x(), -kForce_n.y(), -kForce_n.z(), 50, 50, -free_nm};
  file.their_units = {"N", "N", "N", "mm", "mm", "Nm"};
  const Eigen::Vector3d middle_m(1, 0.5, 0),
      moment_nm = (kActsAt_m - middle_m).cross(kForce_n) + Eigen::Vector3d(0, 0, free_nm);
  exchange::GroundForceRecording read = Read(file);
  EXPECT_LT((read.plates.at(0).force_n[3] - kForce_n).norm(), 1e-3);
  EXPECT_LT((read.plates.at(0).moment_nm[3] - moment_nm).norm(), 1e-3);
  EXPECT_LT((read.plates.at(0).point_m[3] - middle_m).norm(), 1e-6);
  file.channels[3] = file.channels[4] = 5;
  file.their_units[3] = file.their_units[4] = "cm";
  read = Read(file);
  EXPECT_LT((read.plates.at(0).moment_nm[3] - moment_nm).norm(), 1e-3);
}

TEST_F(C3dForces, AreCheckedByTheCentreOfPressure) {
  PlateFile file;
  file.channels = std::vector<double>(6);
  const Eigen::Vector3d turned(1, -1, -1), force = turned.cwiseProduct(kForce_n),
                                           moment = 1000 * turned.cwiseProduct(kMoment_nm);
  for (int i = 0; i < 3; ++i) file.channels[i] = force[i], file.channels[3 + i] = moment[i];
  file.their_units = {"N", "N", "N", "Nm", "Nm", "Nm"};  // they are in N mm
  exchange::GroundForceRecording read = Read(file);
  EXPECT_THAT(read.warnings, testing::ElementsAre(HasSubstr("its moments are taken to be in N mm")));
  EXPECT_LT((read.plates.at(0).moment_nm[3] - kMoment_nm).norm(), 1e-3);
  file.instead["FORCE_PLATFORM:CORNERS"] = {5200, 200, 0, 4800, 200, 0, 4800, 800, 0, 5200, 800, 0};
  file.channels[4] = -3e6;
  read = Read(file);
  EXPECT_THAT(read.warnings, testing::ElementsAre(HasSubstr("the force acts beyond its edges")));
}

TEST_F(C3dForces, WithoutAnyPoint) {
  PlateFile file;
  file.points = 0;
  file.frames = 40;
  const exchange::GroundForceRecording read = Read(file);
  EXPECT_EQ(read.time_s.size(), 80u);
  EXPECT_LT((read.plates.at(0).force_n.back() - kForce_n).norm(), 1e-3);
  EXPECT_TRUE(exchange::HoldsOnlyForces(folder_ / "plate.c3d"));
  EXPECT_THAT(MessageOf([&] { exchange::ReadPoints(folder_ / "plate.c3d"); }),
              testing::AllOf(HasSubstr("holds no markers"), HasSubstr("--forces")));
  file.points = 1;
  EXPECT_FALSE(exchange::HoldsOnlyForces(Write(file)));
}

TEST_F(C3dForces, ThatContradictThemselvesAreRefused) {
  const auto with = [](const std::string& name, const std::vector<double>& values) {
    PlateFile file;
    file.frames = 40;
    file.instead[name] = values;
    return file;
  };
  ExpectRefused(with("FORCE_PLATFORM:USED", {0}), "no force plates");
  for (const int type : {8, 11, 21})
    ExpectRefused(with("FORCE_PLATFORM:TYPE", {static_cast<double>(type)}),
                  fmt::format("plate 1 is of type {}, and types 1 to 7 are those that are publicly described", type));
  ExpectRefused(with("FORCE_PLATFORM:CHANNEL", {1, 2, 3, 4, 5, 7}), "names channel 7, but there are 6");
  ExpectRefused(with("FORCE_PLATFORM:CORNERS", std::vector<double>(12, 0)), "plate 1 has no corners");
  ExpectRefused(with("FORCE_PLATFORM:CORNERS", {4, 0, 0, 3, 0, 0, 2, 0, 0, 1, 0, 0}), "they lie in one line");
  ExpectRefused(with("ANALOG:USED", {0}), "no analogue channels");
  ExpectRefused(with("ANALOG:USED", {2.5}), "no analogue channels");
  ExpectRefused(with("ANALOG:SCALE", {1, 1}), "fewer values than the 6 channels");
  PlateFile unplaced;
  unplaced.without = {"FORCE_PLATFORM:ORIGIN"};
  ExpectRefused(unplaced, "FORCE_PLATFORM:ORIGIN has 0 values");
}

TEST_F(C3dForces, OfAPlateThatCannotBeReadLeaveTheOthers) {
  PlateFile file;
  file.plates = 2;
  const exchange::GroundForceRecording read = Read(file);
  ASSERT_EQ(read.plates.size(), 2u);
  EXPECT_LT((read.plates[0].force_n[3] - kForce_n).norm(), 1e-3);
  EXPECT_EQ(read.plates[1].force_n.size(), read.time_s.size());
  EXPECT_THAT(read.warnings,
              testing::ElementsAre(HasSubstr("force plate 2 names channel 7, but there are 6; it is left out")));
  EXPECT_EQ(exchange::PlateOf(read, {}, "right", "a.c3d").name, "plate 1");
  EXPECT_THAT(MessageOf([&] {
                exchange::PlateOf(read, {{"right", 2}}, "right", "a.c3d");
              }),
              HasSubstr("force plate 2 names channel 7, but there are 6"));
}

// The header says how many analogue samples and points a frame has, the parameters say it again.
TEST_F(C3dForces, WhereTheFileContradictsItselfItsSizeDecides) {
  PlateFile file;
  file.frames = 40;
  file.header_analog = 6;  // the channels, not all samples
  const auto at_the_end = [&] {
    const exchange::GroundForceRecording read = Read(file);
    EXPECT_EQ(read.time_s.size(), 80u);
    EXPECT_LT((read.plates.at(0).force_n.back() - kForce_n).norm(), 1e-3);
    const exchange::PointRecording points = exchange::ReadC3d(folder_ / "plate.c3d");
    EXPECT_EQ(points.time_s.size(), 40u);
    EXPECT_LT((points.points.at(0).positions.back() - PointAt(39)).norm(), 1e-4);
    return points.warnings;
  };
  EXPECT_THAT(at_the_end(), testing::ElementsAre(HasSubstr("analogue samples of a frame: 6 by the header, 12 by")));
  file.header_analog = 0;
  EXPECT_THAT(at_the_end(), testing::ElementsAre(HasSubstr("contradicts itself")));
  file.header_analog.reset();
  EXPECT_TRUE(at_the_end().empty());
  file.header_points = 3;
  EXPECT_THAT(at_the_end(), testing::ElementsAre(HasSubstr("points: 1 by POINT:USED, 3 by the header")));
  file.header_points.reset();
  file.instead["POINT:USED"] = {4};
  EXPECT_THAT(at_the_end(), testing::ElementsAre(HasSubstr("points: 4 by POINT:USED, 1 by the header")));
  file.instead = {{"POINT:LONG_FRAMES", {4000}}};
  EXPECT_THAT(at_the_end(), testing::ElementsAre(HasSubstr("frames: 4000 by POINT:LONG_FRAMES, 40 by the header")));
}

// What a plate measures without anybody on it: in the frames that ZERO names, else where there is no contact.
TEST_F(C3dForces, OfAnEmptyPlateAreSubtracted) {
  PlateFile file;
  file.frames = 60, file.empty_frames = 40;
  file.offset << 3, -4, 25, 800, -2000, 500;
  const auto expect_force = [&](const exchange::GroundForceRecording& read) {
    EXPECT_LT(read.plates.at(0).force_n.front().norm(), 1e-3);
    EXPECT_LT((read.plates.at(0).force_n.back() - kForce_n).norm(), 1e-3);
    EXPECT_LT((read.plates.at(0).moment_nm.back() - kMoment_nm).norm(), 1e-5);
  };
  for (const std::vector<double>& zero : std::vector<std::vector<double>>{{}, {1, 0}, {0, 0}}) {
    file.zero = zero;
    const auto read = Read(file);
    expect_force(read);
    EXPECT_THAT(read.warnings, testing::ElementsAre(testing::AllOf(
                                   HasSubstr("force plate 1: an offset of 25.5 N is subtracted"),
                                   HasSubstr("0.4 s without contact; FORCE_PLATFORM:ZERO names no frames"))));
  }
  file.zero = {12, 20};  // the first frame is number 11
  const auto named = Read(file);
  expect_force(named);
  EXPECT_THAT(named.warnings, testing::ElementsAre(HasSubstr("in frames 12 to 20, which FORCE_PLATFORM:ZERO names")));
  file.zero = {55, 60};  // somebody stands there
  EXPECT_THAT(Read(file).warnings, testing::ElementsAre(HasSubstr("bears 675 N in frames 55 to 60")));
  file.zero = {1, 0};
  file.empty_frames = 0;  // never empty: nothing is known of the offset
  EXPECT_NEAR(Read(file).plates.at(0).force_n.back().z(), kForce_n.z() - 25, 1e-3);
  file.offset.setZero();
  file.empty_frames = 40;
  EXPECT_TRUE(Read(file).warnings.empty());
}

// A foot that rests before a rise bears more than an empty plate measures.
TEST_F(C3dForces, OfAFootAtRestStay) {
  const auto file = SharedData() / "odd_files/c3d-unsigned-offset/signed.c3d";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file.string() << " is not here";
  const auto read = exchange::ReadGroundForces(file);
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_GT(read.plates.at(0).force_n.front().norm(), 20);
}

// The plate of a leg: the one that was named, or the only one that bears a force.
TEST(PlatesOfLegs, AreNamedOrTold) {
  exchange::GroundForceRecording forces;
  forces.time_s = {0, 1};
  for (const double newton : {5.0, 600.0, 650.0})
    forces.plates.push_back({fmt::format("plate_{:g}", newton), {Eigen::Vector3d::Zero(), {0, newton, 0}}, {}, {}, {}});
  const auto message = [&](const std::map<std::string, int>& plates) {
    return MessageOf([&] { exchange::PlateOf(forces, plates, "left", "walk.mot"); });
  };
  EXPECT_EQ(exchange::PlateOf(forces, {{"left", 3}}, "left", "walk.mot").name, "plate_650");
  EXPECT_THAT(message({{"left", 4}}), HasSubstr("no plate 4; it has: 1 is plate_5, 2 is plate_600, 3 is plate_650"));
  EXPECT_THAT(message({{"left", 1}}), HasSubstr("plate 1, plate_5, bears no force"));
  EXPECT_THAT(message({{"right", 2}}), HasSubstr("--plates left=1"));
  forces.plates.pop_back();
  EXPECT_EQ(exchange::PlateOf(forces, {}, "left", "walk.mot").name, "plate_600");
  forces.plates.pop_back();
  EXPECT_THAT(message({}), HasSubstr("no plate bears a force"));
}

TEST(GroundForceTables, WhoseTimesOrColumnsAreWrongAreRefused) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& columns, const std::string& rows) {
    const std::string text = fmt::format("forces\nversion=1\nnRows=2\nnColumns={}\ninDegrees=no\nendheader\ntime{}\n{}",
                                         1 + std::count(columns.begin(), columns.end(), '\t'), columns, rows);
    WriteTextFile(folder / "f.mot", text);
    return MessageOf([&] { exchange::ReadGroundForces(folder / "f.mot"); });
  };
  const std::string all = "\tg_vx\tg_vy\tg_vz\tg_px\tg_py\tg_pz", zeros = "\t0\t0\t0\t0\t0\t0\n";
  EXPECT_EQ(message(all, "0.1" + zeros + "0.1" + zeros), "");
  EXPECT_THAT(exchange::ReadGroundForces(folder / "f.mot").warnings,
              testing::ElementsAre(HasSubstr("rows"), HasSubstr("f.mot:9: a row whose time does not follow")));
  EXPECT_THAT(message("\tknee", "0\t1\n1\t1\n"), HasSubstr("no ground forces"));
  EXPECT_THAT(message("\tg_vx\tg_vy\tg_px\tg_py\tg_pz", "0\t0\t0\t0\t0\t0\n1\t0\t0\t0\t0\t0\n"),
              HasSubstr("of g_vx, y and z one is missing"));
  EXPECT_EQ(message("\tg_vx\tg_vy\tg_vz", "0\t0\t700\t0\n1\t0\t700\t0\n"), "");
  const auto without_point = exchange::ReadGroundForces(folder / "f.mot");  // of use to lake sync
  EXPECT_EQ(without_point.plates.at(0).force_n.at(1).y(), 700);
  EXPECT_THAT(MessageOf([&] {
                exchange::PlateOf(without_point, {{"left", 1}}, "left", "f.mot");
              }),
              HasSubstr("no point where it acts (g_px)"));
  EXPECT_THAT(MessageOf([&] { exchange::ReadGroundForces("forces.txt"); }), HasSubstr("not from '.txt'"));
}

}  // namespace
}  // namespace lake
