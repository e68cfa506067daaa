// Known objects are recognized in a drive: names and poses, and nothing where there is none.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/world/known_objects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "estancia/core/rigid.hpp"
#include "estancia/io/cloud_file.hpp"
#include "estancia/topology/sqlite.hpp"
#include "estancia/world/ask_world.hpp"
#include "estancia/world/world_json.hpp"
#include "estancia/world/world_mapper.hpp"
#include "support/errors.hpp"
#include "support/flat_drive.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::ScratchFolder;

/// Boxes from corner to corner [m].
using Shape = std::vector<std::array<cv::Vec3d, 2>>;

/// No two of its views are alike.
const Shape desk{{{{-0.3, -0.25, 0}, {0.3, 0.25, 0.25}}},
                 {{{-0.3, -0.25, 0.25}, {-0.12, -0.1, 0.7}}},
                 {{{0.1, 0.0, 0.25}, {0.3, 0.25, 0.4}}}};
const Shape shelf{{{{-0.25, -0.1, 0}, {0.25, 0.1, 0.12}}},
                  {{{-0.25, -0.1, 0.12}, {-0.15, 0.1, 0.8}}},
                  {{{-0.15, -0.1, 0.6}, {0.25, 0.0, 0.8}}}};

bool isInside(const Shape& shape, const cv::Vec3d& p) {
  return std::ranges::any_of(shape, [&](const auto& box) {
    return p[0] > box[0][0] && p[1] > box[0][1] && p[2] > box[0][2] && p[0] < box[1][0] && p[1] < box[1][1] &&
           p[2] < box[1][2];
  });
}

/// A point each 8 mm of its surface, times `scale`.
PointCloud cloudOf(const Shape& shape, double scale = 1) {
  constexpr double step = 0.008;
  PointCloud cloud;
  for (const auto& [low, high] : shape)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1}) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        cv::Vec3d p, normal;
        p[axis] = side < 0 ? low[axis] : high[axis];
        normal[axis] = side;
        for (p[a] = low[a] + step / 2; p[a] < high[a]; p[a] += step)
          for (p[b] = low[b] + step / 2; p[b] < high[b]; p[b] += step) {
            if (isInside(shape, p + 1e-4 * normal)) continue;
            cloud.points.emplace_back(cv::Vec3f(scale * p));
            cloud.normals.emplace_back(cv::Vec3f(normal));
          }
      }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

/// A shape that stands in a room, seen from all around.
class ShapeDrive : public test::FlatDrive {
 public:
  explicit ShapeDrive(Shape shape) : shape_(std::move(shape)) {
    intrinsics_ = CameraIntrinsics{240, 180, 197, 197, 119.5, 89.5};
    frames_.resize(12);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size());
      frames_[i].pose = test::lookingAt(0.3 + 1.5 * std::cos(angle), -0.2 + 1.5 * std::sin(angle), 1.1,
                                        angle + std::numbers::pi, -0.5);
    }
  }
  static cv::Affine3d placeOfShape() {
    return {cv::Vec3d(0, 0, 35 * std::numbers::pi / 180), cv::Vec3d(0.3, -0.2, 0)};
  }
  cv::Mat image(std::size_t) const override { return {180, 240, CV_8UC3, cv::Scalar(10, 20, 30)}; }
  cv::Mat depth(std::size_t i) const override {
    const cv::Affine3d pose = rigidOf(*frames_[i].pose), inShape = placeOfShape().inv() * pose;
    cv::Mat depth(180, 240, CV_32F);
    for (int v = 0; v < depth.rows; ++v)
      for (int u = 0; u < depth.cols; ++u) {
        const cv::Vec3d ray(intrinsics_->slopeX(u), intrinsics_->slopeY(v), 1);
        double z = crossing({-3, -3, 0}, {3, 3, 2.5}, pose.translation(), pose.rotation() * ray).second;
        for (const auto& [low, high] : shape_) {
          const auto [enter, leave] = crossing(low, high, inShape.translation(), inShape.rotation() * ray);
          if (enter < leave) z = std::min(z, enter);
        }
        depth.at<float>(v, u) = static_cast<float>(z);
      }
    return depth;
  }

 private:
  static std::pair<double, double> crossing(const cv::Vec3d& low, const cv::Vec3d& high,
                                            const cv::Vec3d& from, const cv::Vec3d& ray) {
    double enter = 0, leave = 100;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - from[axis]) / ray[axis], b = (high[axis] - from[axis]) / ray[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return {enter, leave};
  }
  Shape shape_;
};

/// Maps the drive's frames up to `end`, beginning or going on.
WorldMap mapWith(const ShapeDrive& drive, std::size_t end, const fs::path& file,
                 const std::shared_ptr<const KnownObjects>& known) {
  const DescriptorSequence labeled = drive.labeled();
  {
    MappingSession session =
        fs::exists(file) ? MappingSession::resume(file, labeled.vocabulary, labeled.model)
                         : MappingSession::create(file, labeled.vocabulary, labeled.model, MapperOptions{});
    WorldMapper world(session);
    if (known) world.recognize(known);
    for (std::size_t i = session.frames(); i < end; ++i) {
      world.observe(drive.frame(i), labeled.descriptors.row(i), drive.image(i), drive.depth(i),
                    *drive.intrinsics());
      session.add(drive.frame(i), labeled.descriptors.row(i));
    }
    session.finish();
    world.finish();
  }
  return readWorld(file);
}

std::shared_ptr<const KnownObjects> knownBy(const std::vector<ModelFile>& files) {
  return std::make_shared<const KnownObjects>(files);
}

void expectDesk(const WorldMap& world) {
  ASSERT_EQ(world.objects.size(), 1U);
  const WorldObject& object = world.objects.front();
  ASSERT_TRUE(object.known);
  EXPECT_EQ(object.displayName(), "desk");
  EXPECT_GT(object.known->confidence, 0.6);
  EXPECT_EQ(object.probability(), object.known->confidence);
  const cv::Affine3d error = ShapeDrive::placeOfShape().inv() * rigidOf(object.known->pose);
  EXPECT_LT(cv::norm(error.translation()), 0.02);
  EXPECT_LT(angleOf(error) * 180 / std::numbers::pi, 2);
}

TEST(KnownObjects, GiveNamesAndPosesToTheObjectsThatTheyAre) {
  const ScratchFolder folder;
  writeCloud(cloudOf(desk), folder / "desk.ply");
  writeCloud(cloudOf(shelf), folder / "shelf.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}, {"shelf", folder / "shelf.ply"}});
  const WorldMap world = mapWith(ShapeDrive(desk), 12, folder / "map.estancia", known);
  expectDesk(world);
  const WorldAnswers answers = askWorld(world, "Desk");
  ASSERT_EQ(answers.objects.size(), 1U);
  EXPECT_TRUE(answers.objects[0].isKnown);
  EXPECT_TRUE(answers.objects[0].isLikely());
  EXPECT_EQ(answers.objects[0].probability, world.objects[0].known->confidence);
  EXPECT_TRUE(answers.places.empty());
  EXPECT_THAT([&] { askWorld(world, "shelf"); }, FailsWith(ErrorCode::noAnswer));
  EXPECT_THAT(findNearNames(world, "desc"), testing::Contains("desk"));
  const auto json = toJson("desk", answers, world)["objects"][0];
  EXPECT_EQ(json["name"], "desk");
  EXPECT_EQ(json["recognized"], true);
  EXPECT_NEAR(json["known"]["position"][0].get<double>(), 0.3, 0.02);
  EXPECT_EQ(json["known"]["orientation"].size(), 4U);
  EXPECT_THAT(knownText(world.objects[0]), testing::HasSubstr("recognized as desk"));
}

TEST(KnownObjects, AreNotFoundWhereTheyAreNot) {
  const ScratchFolder folder;
  writeCloud(cloudOf(shelf), folder / "shelf.ply");
  const WorldMap world =
      mapWith(ShapeDrive(desk), 12, folder / "map.estancia", knownBy({{"shelf", folder / "shelf.ply"}}));
  ASSERT_EQ(world.objects.size(), 1U);
  EXPECT_FALSE(world.objects[0].known);
  sqlite::Database database(folder / "map.estancia", sqlite::Database::Mode::read);
  EXPECT_EQ(database.number("SELECT count(*) FROM recognitions"), 3) << "the best views";
  EXPECT_EQ(database.number("SELECT count(confidence) FROM recognitions"), 0);
}

TEST(KnownObjects, StayFoundAndMayBeGivenAfterTheDrive) {
  const ScratchFolder folder;
  const ShapeDrive drive(desk);
  const fs::path file = folder / "map.estancia";
  EXPECT_FALSE(mapWith(drive, 8, file, nullptr).objects.at(0).known);
  writeCloud(cloudOf(desk), folder / "desk.ply");
  const auto known = knownBy({{"desk", folder / "desk.ply"}});
  expectDesk(mapWith(drive, 8, file, known));
  expectDesk(mapWith(drive, 12, file, nullptr));
  const auto tries = [&file] {
    return sqlite::Database(file, sqlite::Database::Mode::read).number("SELECT count(*) FROM recognitions");
  };
  const std::int64_t before = tries();
  expectDesk(mapWith(drive, 12, file, known));
  EXPECT_EQ(tries(), before) << "it is found already";
  writeCloud(cloudOf(shelf), folder / "desk.ply");
  EXPECT_FALSE(mapWith(drive, 12, file, knownBy({{"desk", folder / "desk.ply"}})).objects.at(0).known)
      << "another cloud of that name";
}

TEST(KnownObjects, OfADamagedMapAreRefused) {
  const ScratchFolder folder;
  writeCloud(cloudOf(desk), folder / "desk.ply");
  const fs::path file = folder / "map.estancia";
  mapWith(ShapeDrive(desk), 12, file, knownBy({{"desk", folder / "desk.ply"}}));
  for (const char* damage : {"object = 7", "frame = 99", "confidence = 2", "qw = 'x', qx = 1e300 * 1e300"}) {
    const fs::path copy = folder / "damaged.estancia";
    fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
    sqlite::Database(copy, sqlite::Database::Mode::write)
        .run(std::string("UPDATE object_poses SET ") + damage);
    EXPECT_THAT([&] { readWorld(copy); }, FailsWith(ErrorCode::corruptFile)) << damage;
  }
}

TEST(KnownObjects, SayWhichCloudCannotBeUsed) {
  const ScratchFolder folder;
  const auto known = [](const fs::path& file) { return [file] { KnownObjects({{"desk", file}}); }; };
  EXPECT_THAT(known(folder / "missing.ply"), FailsWith(ErrorCode::fileNotFound, "missing.ply"));
  PointCloud few = cloudOf(desk);
  few.points.resize(5), few.normals.resize(5), few.width = 5;
  writeCloud(few, folder / "few.ply");
  EXPECT_THAT(known(folder / "few.ply"), FailsWith(ErrorCode::insufficientData, "few.ply"));
  writeCloud(cloudOf(desk, 1000), folder / "millimeters.ply");
  EXPECT_THAT(known(folder / "millimeters.ply"), FailsWith(ErrorCode::invalidInput, "millimeters by 0.001"));
  writeCloud(cloudOf({{{{0, 0, 0}, {0.5, 0.5, 0.001}}}}), folder / "sheet.ply");
  EXPECT_THAT(known(folder / "sheet.ply"), FailsWith(ErrorCode::invalidInput, "planar"));
  writeCloud(cloudOf(desk), folder / "desk.ply");
  EXPECT_THAT(
      [&] {
        KnownObjects({{"desk", folder / "desk.ply"}, {"desk", folder / "desk.ply"}});
      },
      FailsWith(ErrorCode::invalidOption, "desk"));
}

}  // namespace
}  // namespace estancia
