// Data sets in the layout of BOP, and its measures by values that were worked out on paper.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "recognition/bop.hpp"
#include "recognition/bop_measures.hpp"
#include "recognition/bop_results.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia::experiments {
namespace {

using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::Each;
using testing::ElementsAre;
namespace fs = std::filesystem;

const CameraIntrinsics vga{640, 480, 525, 525, 319.5, 239.5};

cv::Affine3d shifted(double x, double y, double z) {
  return {cv::Matx33d::eye(), cv::Vec3d(x, y, z)};
}
cv::Affine3d turned(double angle) {
  return cv::Affine3d(cv::Vec3d(0, 0, angle));
}

/// A prism that stands on its polygon, which is counter-clockwise [m].
void addPrism(PlyMesh& mesh, const std::vector<cv::Point2f>& polygon, float low, float high) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.points.size()),
             n = static_cast<std::uint32_t>(polygon.size());
  for (const float z : {low, high})
    for (const cv::Point2f& p : polygon) mesh.vertices.points.emplace_back(p.x, p.y, z);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = first + i, b = first + (i + 1) % n;
    mesh.triangles.push_back({a, b, b + n});
    mesh.triangles.push_back({a, b + n, a + n});
    if (i < 2) continue;
    mesh.triangles.push_back({first, first + i, first + i - 1});
    mesh.triangles.push_back({first + n, first + n + i - 1, first + n + i});
  }
}

/// Boxes and cylinders, as Solid has them, as a mesh.
PlyMesh meshOf(const std::vector<Solid>& solids) {
  PlyMesh mesh;
  for (const Solid& solid : solids) {
    const int corners = solid.shape == Solid::Shape::box ? 4 : 120;
    const double reach = corners == 4 ? std::numbers::sqrt2 / 2 : 0.5;
    std::vector<cv::Point2f> polygon;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.5) / corners;
      polygon.emplace_back(solid.at[0] + reach * solid.size[0] * std::cos(angle),
                           solid.at[1] + reach * solid.size[1] * std::sin(angle));
    }
    addPrism(mesh, polygon, static_cast<float>(solid.at[2]), static_cast<float>(solid.at[2] + solid.size[2]));
  }
  return mesh;
}

/// Two steps, which look the same in no other pose, and a can, which does in many.
const std::vector<Solid> steps{{Solid::Shape::box, {0, 0, 0}, {0.14, 0.09, 0.05}, 0},
                               {Solid::Shape::box, {0.045, 0.01, 0.05}, {0.05, 0.07, 0.06}, 0}};
const std::vector<Solid> can{{Solid::Shape::cylinder, {0, 0, 0}, {0.08, 0.08, 0.12}, 0}};

/// A square of a meter in the plane z = 0.
BopObject square() {
  BopObject object;
  object.mesh.vertices.points = {{-0.5F, -0.5F, 0}, {0.5F, -0.5F, 0}, {0.5F, 0.5F, 0}, {-0.5F, 0.5F, 0}};
  object.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  object.diameter = std::numbers::sqrt2;
  object.symmetries = {cv::Affine3d::Identity()};
  return object;
}

TEST(BopMeasures, MeshesAreRenderedAsRaysMeetThem) {
  const cv::Affine3d pose(cv::Vec3d(-2, 0.3, 0.2), cv::Vec3d(0.05, 0.02, 0.6));
  for (const auto& solids : {steps, can}) {
    const cv::Mat mesh = renderMesh(meshOf(solids), pose, vga), rays = renderSolids(solids, pose, vga);
    const int seen = cv::countNonZero(rays);
    ASSERT_GT(seen, 5000);
    EXPECT_NEAR(cv::countNonZero(mesh), seen, 0.01 * seen);
    EXPECT_LT(cv::countNonZero(cv::abs(mesh - rays) > 0.001), 0.01 * seen) << "but for the outline";
  }
  EXPECT_EQ(cv::countNonZero(renderMesh(square().mesh, shifted(0, 0, -1), vga)), 0) << "behind the camera";
  EXPECT_EQ(cv::countNonZero(renderMesh(square().mesh, shifted(1e7, 1e7, 0.1), vga)), 0) << "far aside";
}

TEST(BopMeasures, MssdIsTheLengthOfATranslation) {
  const cv::Affine3d truth = shifted(0, 0, 2) * cv::Affine3d(cv::Vec3d(0.5, 1, 2));
  EXPECT_NEAR(maxSurfaceDistance(square(), shifted(0.03, 0, 0.04) * truth, truth), 0.05, 1e-9);
  // A quarter of a turn moves each corner by a side; the square looks the same then.
  BopObject object = square();
  EXPECT_NEAR(maxSurfaceDistance(object, truth * turned(std::numbers::pi / 2), truth), 1, 1e-9);
  object.symmetries.push_back(turned(std::numbers::pi / 2));
  EXPECT_NEAR(maxSurfaceDistance(object, truth * turned(std::numbers::pi / 2), truth), 0, 1e-9);
}

TEST(BopMeasures, TurnsAboutAnAxisCostLessThanAStep) {
  BopObject object = square();
  const cv::Vec3d axis(0, 0, 3), corner(0.5, 0.5, 0);
  object.symmetries = bopTurns(axis, {});
  EXPECT_EQ(object.symmetries.size(), 315U) << "⌈π / 0.01⌉";
  for (const double angle : {0.005, 1.234, 3.0, -2.0}) {
    EXPECT_LT(maxSurfaceDistance(object, turned(angle), cv::Affine3d::Identity()), 0.005 * object.diameter);
    EXPECT_LT(maxProjectionDistance(object, shifted(0, 0, 2) * turned(angle), shifted(0, 0, 2), vga),
              0.005 * object.diameter * 525 / 2);
  }
  for (const cv::Affine3d& turn : bopTurns(axis, corner)) EXPECT_LT(cv::norm(turn * corner - corner), 1e-12);
}

TEST(BopMeasures, MspdIsTheProjectionOfAShift) {
  const double expected = 525 * 0.04 / 2;  // f t / z
  EXPECT_NEAR(maxProjectionDistance(square(), shifted(0.04, 0, 2), shifted(0, 0, 2), vga), expected, 1e-9);
  EXPECT_EQ(maxProjectionDistance(square(), shifted(0, 0, -2), shifted(0, 0, 2), vga), HUGE_VAL);
}

TEST(BopMeasures, VsdComparesWhatIsVisible) {
  const BopObject object = square();
  const auto at = [&](double z) { return renderMesh(object.mesh, shifted(0, 0, z), vga); };
  const auto vsd = [&](const cv::Mat& measured, const cv::Mat& found, double delta) {
    return visibleSurfaceDiscrepancy({measured, at(2), found}, vga, delta, object.diameter);
  };
  const cv::Mat unknown = cv::Mat::zeros(480, 640, CV_32F);
  for (const cv::Mat& measured : {at(2), unknown, at(2.01), at(1.99)})
    EXPECT_THAT(vsd(measured, at(2), 0.015), Each(0)) << "the truth";
  EXPECT_THAT(vsd(cv::Mat(480, 640, CV_32F, cv::Scalar(1)), at(2), 0.015), Each(1)) << "nothing is visible";
  // 0.2 m are 14 % of the diameter; seen from 2.2 m, the square covers (2 / 2.2)² of its pixels.
  const double aside = 1 - std::pow(2 / 2.2, 2);
  const auto farther = vsd(unknown, at(2.2), 0.015);
  EXPECT_THAT(std::vector(farther.begin(), farther.begin() + 2), Each(1));
  EXPECT_THAT(std::vector(farther.begin() + 3, farther.end()), Each(testing::DoubleNear(aside, 0.01)));
  EXPECT_THAT(vsd(at(2), at(2.2), 0.015), Each(testing::Ge(aside - 0.01)))
      << "it counts where the truth is seen";
  // A half that something hides does not count.
  cv::Mat half = at(2).clone();
  half.colRange(0, 320).setTo(1);
  cv::Mat other = at(2).clone();
  other.colRange(0, 320).setTo(0);
  EXPECT_THAT(vsd(half, other, 0.015), Each(0));
  EXPECT_THAT(vsd(at(2), other, 0.015), Each(testing::DoubleNear(0.5, 0.01)));
}

TEST(BopMeasures, TheSurestEstimateChoosesFirst) {
  const std::vector<std::vector<double>> errors{{0.1, 0.2}, {0.05, 0.3}, {0.05, 0.05}};
  EXPECT_EQ(matchEstimates(errors, 0.1), 2U) << "an error of the threshold is none";
  EXPECT_EQ(matchEstimates(errors, 0.25), 2U) << "the second one finds its instance taken";
  EXPECT_EQ(matchEstimates({errors[0], errors[1]}, 0.25), 1U) << "the first one took its instance";
  EXPECT_EQ(matchEstimates({errors[0], errors[1]}, 0.31), 2U);
  EXPECT_EQ(matchEstimates({}, 1), 0U);
}

TEST(BopMeasures, AsManyInstancesAsAskedForCountTheMostVisible) {
  const BopObject object = square();
  BopImage image{1, 1};
  image.truth = {{7, shifted(0, 0, 3), 0.2},
                 {8, shifted(0, 0, 4), 1},
                 {7, shifted(2, 0, 6), 0.9},
                 {7, shifted(0, 0, 5), 0.1}};
  const DepthFrame frame{"", cv::Mat::zeros(480, 640, CV_32F), vga};
  const auto judged = [&](std::size_t instances, const std::vector<cv::Affine3d>& estimates) {
    return judgeEstimates({7, instances}, object, estimates, image, frame, 0.015);
  };
  const BopScore one = judged(1, {shifted(0, 0, 3), shifted(2, 0, 6)});
  EXPECT_EQ(one.targets, 1);
  EXPECT_EQ(one.recall(), 0) << "the first estimate is of one that is less visible";
  const BopScore two = judged(2, {shifted(0, 0, 3), shifted(2, 0, 6), shifted(0, 0, 5)});
  EXPECT_EQ(two.targets, 2);
  EXPECT_NEAR(two.recall(), 1, 1e-12);
  // 0.2 m in a diameter of 1.41 m: right by the thresholds of 15 % … 50 %; 17.5 pixels: by 20 … 50.
  const BopScore aside = judged(1, {shifted(2.2, 0, 6)});
  EXPECT_NEAR(aside.mssd, 0.8, 1e-12);
  EXPECT_NEAR(aside.mspd, 0.7, 1e-12);
}

/// A data set of two images of a table, in the published layout.
class Bop : public testing::Test {
 protected:
  void SetUp() override {
    writeModel("000001", meshOf(steps));
    writeModel("000002", meshOf(can));
    writeFile(root / "models_eval/models_info.json",
              R"({"1": {"diameter": 199.8, "min_x": -70}, "2": {"diameter": 144.2,)"
              R"("symmetries_discrete": [[1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 120, 0, 0, 0, 1]],)"
              R"("symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}})");
    addImage(0, {{1, turnedAt(0.5, -0.12, 0)}, {2, turnedAt(0, 0.12, 0.05)}});
    addImage(7, {{2, turnedAt(1, -0.1, 0.1)}, {1, turnedAt(-2, 0.1, -0.05)}});
    writeFile(scene / "scene_camera.json", fmt::format("{{{}}}", fmt::join(cameras, ",")));
    writeFile(scene / "scene_gt.json", fmt::format("{{{}}}", fmt::join(poses, ",")));
    writeFile(scene / "scene_gt_info.json", fmt::format("{{{}}}", fmt::join(infos, ",")));
    writeFile(root / "test_targets_bop19.json", fmt::format("[{}]", fmt::join(targets, ",")));
  }

  void writeModel(const std::string& id, const PlyMesh& mesh) const {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.points.size(), mesh.triangles.size());
    for (const cv::Point3f& p : mesh.vertices.points)
      text += fmt::format("{} {} {}\n", 1000 * p.x, 1000 * p.y, 1000 * p.z);
    for (const auto& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    writeFile(root / ("models_eval/obj_" + id + ".ply"), text);
  }

  static cv::Affine3d turnedAt(double angle, double x, double y) { return shifted(x, y, 0) * turned(angle); }

  /// T_table_model of objects; the camera looks down on the table from 0.8 m.
  void addImage(int id, const std::vector<std::pair<int, cv::Affine3d>>& objects) {
    constexpr double pitch = 0.8, away = 0.8;
    const double c = std::cos(pitch), s = std::sin(pitch);
    const cv::Affine3d table(cv::Matx33d(1, 0, 0, 0, -s, -c, 0, c, -s), cv::Vec3d(0, 0, away));
    cv::Mat_<float> depth(vga.height, vga.width);
    for (int v = 0; v < depth.rows; ++v) depth.row(v) = away * s / (c * vga.slopeY(v) + s);
    std::vector<std::string> truth, visible;
    for (const auto& [object, at] : objects) {
      const cv::Affine3d pose = table * at;
      const cv::Mat_<float> solid = renderSolids(object == 1 ? steps : can, pose, vga);
      solid.copyTo(depth, solid > 0);
      const cv::Matx33d r = pose.rotation();
      const cv::Vec3d t = pose.translation() * 1000;
      truth.push_back(fmt::format(R"({{"cam_R_m2c": [{}], "cam_t_m2c": [{}], "obj_id": {}}})",
                                  fmt::join(r.val, r.val + 9, ","), fmt::join(t.val, t.val + 3, ","),
                                  object));
      visible.push_back(R"({"visib_fract": 1.0})");
      targets.push_back(
          fmt::format(R"({{"scene_id": 3, "im_id": {}, "obj_id": {}, "inst_count": 1}})", id, object));
    }
    cv::Mat noise(depth.size(), CV_32F), raw;
    cv::RNG(static_cast<std::uint64_t>(id)).fill(noise, cv::RNG::NORMAL, 0, 0.0007);
    cv::Mat(depth + noise).convertTo(raw, CV_16U, 10'000);  // 0.1 mm
    fs::create_directories(scene / "depth");
    cv::imwrite((scene / "depth" / fmt::format("{:06}.png", id)).string(), raw);
    cameras.push_back(
        fmt::format(R"("{}": {{"cam_K": [525, 0, 319.5, 0, 525, 239.5, 0, 0, 1], "depth_scale": 0.1}})", id));
    poses.push_back(fmt::format(R"("{}": [{}])", id, fmt::join(truth, ",")));
    infos.push_back(fmt::format(R"("{}": [{}])", id, fmt::join(visible, ",")));
  }

  Findings run(const std::string& keys = "", const std::string& out = "out") const {
    writeFile(folder / "bop.toml", "type = \"bop\"\n[[dataset]]\nname = \"made\"\npath = \"made\"\n" + keys);
    ExperimentRun run;
    run.folder = folder / out;
    return runExperiment({folder / "bop.toml"}, run, Progress::none());
  }
  BopData read() const {
    BopSource source;
    source.path = root;
    return readBop(source);
  }

  test::ScratchFolder folder;
  const fs::path root = folder / "made", scene = root / "test/000003";
  std::vector<std::string> cameras, poses, infos, targets;
};

std::vector<std::optional<double>> rowOf(const Findings& findings, const std::string& name) {
  const auto& table = std::get<ResultTable>(findings.sections.at(0));
  return std::ranges::find(table.rows, name, &ResultTable::Row::name)->values;
}

TEST_F(Bop, ObjectsOnATableAreFoundAndWritten) {
  const Findings findings = run();
  const auto all = rowOf(findings, "all");
  EXPECT_EQ(all.at(0), 4);
  EXPECT_GT(*all.at(5), 85) << "average recall [%]";
  const std::vector<BopEstimate> estimates = readBopResults(folder / "out/estancia_made-test.csv");
  EXPECT_EQ(static_cast<double>(estimates.size()), all.at(1));
  EXPECT_EQ(readFile(folder / "out/results.csv").find("dataset,scene,image,object,targets"), 0U);
  // Nothing changes by the cells that are kept, and by the file that was written.
  EXPECT_EQ(rowOf(run(), "all"), all);
  EXPECT_EQ(rowOf(run("results = \"out/estancia_made-test.csv\"\n", "again"), "all"), all);
  EXPECT_EQ(rowOf(run("images = 1\n", "few"), "all").at(0), 2);
}

TEST_F(Bop, TheTruthHasAllRecall) {
  std::vector<BopEstimate> estimates;
  for (const BopImage& image : read().images)
    for (const BopInstance& one : image.truth)
      estimates.push_back({image.scene, image.image, one.object, 1,
                           one.pose * turned(one.object == 2 ? 1.5 : 0), image.image == 0 ? 0.5 : 1});
  const auto judged = [&](const std::string& object) {
    writeBopResults(folder / "truth.csv", estimates);
    return rowOf(run("results = \"truth.csv\"\n"), object);
  };
  EXPECT_THAT(judged("all"), ElementsAre(4, 4, 100, 100, 100, 100, 0.75));
  for (BopEstimate& one : estimates) one.pose = shifted(0.06, 0, 0) * one.pose;
  EXPECT_EQ(judged("1").at(3), 40) << "6 cm are 30.03 % of the diameter: right by 35 … 50 %";
  estimates.resize(1);
  estimates[0].seconds = -1;
  EXPECT_EQ(judged("all").at(6), std::nullopt) << "an unknown time";
}

TEST_F(Bop, IsReadInMetersWithItsSymmetries) {
  const BopData data = read();
  ASSERT_EQ(data.images.size(), 2U);
  EXPECT_EQ(data.images[1].image, 7);
  EXPECT_EQ(data.images[1].camera.cx, 319.5);
  EXPECT_EQ(data.objects.at(1).symmetries.size(), 1U);
  EXPECT_EQ(data.objects.at(2).symmetries.size(), 2U * 315);
  EXPECT_NEAR(data.objects.at(2).diameter, 0.1442, 1e-12);
  EXPECT_LT(cv::norm(data.objects.at(2).symmetries[315] * cv::Vec3d(0, 0, 0.12)), 1e-9) << "turned over";
  EXPECT_NEAR(cv::norm(data.images[0].truth[0].pose.translation()), 0.8, 0.2);
  const cv::Mat depth = readBopDepth(data.images[0]).depth;
  EXPECT_NEAR(depth.at<float>(240, 320), 0.8, 0.005);
  // Points of the surface, evenly: as many on the can's hull as its share of the area.
  const PointCloud points = sampleMesh(data.objects.at(2).mesh, 0.002);
  const auto hull =
      std::ranges::count_if(points.points, [](const auto& p) { return p.z > 1e-6 && p.z < 0.12 - 1e-6; });
  EXPECT_NEAR(static_cast<double>(hull) / static_cast<double>(points.points.size()), 0.75, 0.01);
}

TEST_F(Bop, ResultsAreReadAsTheyWereWritten) {
  const BopEstimate one{3, 7, 2, 0.25, cv::Affine3d(cv::Vec3d(1, 2, 0.5), cv::Vec3d(0.1, -0.2, 0.7)), 1.5};
  writeBopResults(folder / "r.csv", std::vector{one, one});
  const auto read = readBopResults(folder / "r.csv");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_LT(cv::norm(read[1].pose.matrix, one.pose.matrix), 1e-12);
  EXPECT_THAT(std::vector<double>({read[1].score, read[1].seconds}), ElementsAre(0.25, 1.5));
  EXPECT_EQ(read[1].object, 2);
  const std::string pose = "1 0 0 0 1 0 0 0 1,0 0 900,-1\n";
  writeFile(folder / "r.csv", "1,0,5,0.5," + pose);
  EXPECT_NEAR(readBopResults(folder / "r.csv").at(0).pose.translation()[2], 0.9, 1e-12);
  for (const std::string& row : {"1,0,0.5," + pose, "1,0,-5,0.5," + pose, "1,0,../5,0.5," + pose,
                                 "1,0,5,nan," + pose, std::string("1,0,5,1,1 0 0 0 1 0 0 0,0 0 900,-1\n"),
                                 std::string("1,0,5,1,1 0 0 0 1 0 0 0 -1,0 0 900,-1\n")}) {
    writeFile(folder / "r.csv", "scene_id,im_id,obj_id,score,R,t,time\n" + row);
    EXPECT_THAT([&] { readBopResults(folder / "r.csv"); }, FailsWith(ErrorCode::malformedFile, "r.csv:2"))
        << row;
  }
}

TEST_F(Bop, WhatIsMissingOrWrongIsNamed) {
  const auto refuses = [&](const fs::path& file, const std::string& from, const std::string& to,
                           ErrorCode code) {
    const std::string whole = readFile(file);
    std::string changed = whole;
    ASSERT_NE(changed.find(from), std::string::npos) << from;
    changed.replace(changed.find(from), from.size(), to);
    writeFile(file, changed);
    EXPECT_THAT([&] { read(); }, FailsWith(code, file.filename().string())) << to;
    writeFile(file, whole);
  };
  const auto wrong = ErrorCode::malformedFile;
  const fs::path list = root / "test_targets_bop19.json", info = root / "models_eval/models_info.json";
  refuses(list, "\"scene_id\": 3", "\"scene_id\": -3", wrong);
  refuses(list, "\"im_id\": 0", "\"im_id\": \"../0\"", wrong);
  refuses(list, "\"obj_id\": 1", "\"obj_id\": 1000000", wrong);
  refuses(list, "\"inst_count\": 1", "\"inst_count\": 1000000000", wrong);
  refuses(list, "\"obj_id\": 1", "\"obj_id\": 2", wrong);
  refuses(list, "]", "", wrong);
  refuses(scene / "scene_camera.json", "\"7\"", "\"8\"", wrong);
  refuses(scene / "scene_camera.json", "525", "0", wrong);
  refuses(scene / "scene_camera.json", "0.1", "0", wrong);
  refuses(scene / "scene_gt.json", "\"cam_R_m2c\": [", "\"cam_R_m2c\": [7,", wrong);
  refuses(scene / "scene_gt.json", "\"cam_R_m2c\": [", "\"cam_R_m2c\": [0,0,0,0,0,0,0,0,0],\"was\": [",
          wrong);
  refuses(scene / "scene_gt_info.json", "{\"visib_fract\": 1.0},", "", ErrorCode::mismatch);
  refuses(info, "199.8", "null", wrong);
  refuses(info, "\"axis\": [0, 0, 1]", "\"axis\": [0, 0, 0]", wrong);
  refuses(root / "models_eval/obj_000002.ply", "3 0 1 121", "3 0 1 999", wrong);
  for (const fs::path& file : {list, info, scene / "scene_gt.json", root / "models_eval/obj_000001.ply"}) {
    fs::rename(file, folder / "away");
    EXPECT_THAT([&] { read(); }, FailsWith(ErrorCode::fileNotFound, file.filename().string()));
    fs::rename(folder / "away", file);
  }
  fs::remove(scene / "depth/000007.png");
  writeBopResults(folder / "none.csv", {});
  EXPECT_THAT([&] { run("results = \"none.csv\"\n"); }, FailsWith(ErrorCode::fileNotFound, "000007.png"));
}

TEST_F(Bop, NamesStayInTheirFoldersAndAbsentDataIsLeftOut) {
  for (const char* keys : {"split = \"../test\"\n", "split = \"..\"\n", "targets = \"/etc/passwd\"\n",
                           "images = -1\n", "[[dataset]]\nname = \"made\"\npath = \"b\"\n"})
    EXPECT_THAT([&] { run(keys); }, FailsWith(ErrorCode::malformedFile, "bop.toml")) << keys;
  EXPECT_THAT([&] { run("split = \"val\"\n"); }, FailsWith(ErrorCode::fileNotFound, "scene_camera.json"));
  fs::remove_all(root);
  EXPECT_THAT([&] { run(); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { run("optional = true\n"); }, FailsWith(ErrorCode::insufficientData));
}

}  // namespace
}  // namespace estancia::experiments
