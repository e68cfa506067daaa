// SPDX-License-Identifier: Apache-2.0
#include "estancia/recognition/recognizer.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "estancia/core/error.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/recognition/object_search.hpp"
#include "estancia/recognition/prepared.hpp"
#include "recognition/made_up_surface.hpp"
#include "support/errors.hpp"
#include "support/support.hpp"

namespace estancia {
namespace {

using test::centerOf;
using test::FailsWith;
using test::PoseError;
using test::poseError;

/// A wavy object in front of a wall.
struct Scenery {
  PointCloud scene, model;
  cv::Affine3d truth{cv::Vec3d(0.15, -0.1, 0.4), cv::Vec3d(0.05, -0.02, 0.1)};

  explicit Scenery(float scale = 1) {
    scene = test::wavySheet(70, 0.25, 1, 0.001);
    model = test::moved(scene, truth.inv());
    for (const cv::Point3f& p : test::wavySheet(130, 0.65, 2).points)
      scene.points.emplace_back(p.x, p.y, 1 + 0.05F * std::fmod(100 * p.x, 0.02F));
    scene.normals.clear();
    for (PointCloud* cloud : {&scene, &model})
      for (cv::Point3f& p : cloud->points) p *= scale;
    truth = cv::Affine3d(truth.rotation(), truth.translation() * scale);
  }
};

std::vector<Detection> findIn(const RecognitionOptions& options, const PointCloud& model,
                              const PointCloud& scene) {
  const Recognizer recognizer(options);
  return recognizer.find(*recognizer.prepareModel("model", model), *recognizer.prepareScene("scene", scene));
}

testing::AssertionResult isFound(const std::vector<Detection>& found, const Scenery& scenery,
                                 double scale = 1) {
  if (found.empty()) return testing::AssertionFailure() << "nothing found";
  const PoseError e = poseError(found[0].pose, scenery.truth, centerOf(scenery.model));
  if (e.translation > 0.004 * scale || e.rotation > 1.5)
    return testing::AssertionFailure() << e.translation << " m, " << e.rotation << " degrees off";
  if (found[0].model != "model" || !(found[0].confidence > 0.7) || found[0].inliers < 100)
    return testing::AssertionFailure()
           << found[0].model << ", " << found[0].confidence << ", " << found[0].inliers;
  return testing::AssertionSuccess();
}

TEST(Recognizer, FindsTheModelWithEachPreset) {
  const Scenery scenery;
  for (const std::string preset : {"default", "classical", "thesis", "author-2014", "tight", "wide"})
    EXPECT_TRUE(isFound(findIn(RecognitionOptions::preset(preset), scenery.model, scenery.scene), scenery))
        << preset;
}

TEST(Recognizer, FindsTheModelWithEachStage) {
  const Scenery scenery;
  const auto with = [&](auto&& change) {
    RecognitionOptions options = RecognitionOptions::preset("classical");
    change(options);
    return isFound(findIn(options, scenery.model, scenery.scene), scenery);
  };
  EXPECT_TRUE(with([](auto& o) { o.descriptor = "fpfh"; }));
  EXPECT_TRUE(with([](auto& o) { o.descriptor = "spin-image"; }));
  EXPECT_TRUE(with([](auto& o) { o.keypoints = "harris3d"; }));
  EXPECT_TRUE(with([](auto& o) { o.keypoints = "iss"; }));
  EXPECT_TRUE(with([](auto& o) { o.grouping = "hough"; }));
  EXPECT_TRUE(with([](auto& o) { o.verification = "global"; }));
  EXPECT_TRUE(with([](auto& o) { o.matchEach = "scene"; }));
}

TEST(Recognizer, ThreadsDoNotMatter) {
  const Scenery scenery;
  RecognitionOptions options = RecognitionOptions::preset("classical");
  options.threads = 1;
  const auto one = findIn(options, scenery.model, scenery.scene);
  options.threads = 3;
  const auto three = findIn(options, scenery.model, scenery.scene);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pose.matrix, three[i].pose.matrix);
    EXPECT_EQ(one[i].confidence, three[i].confidence);
  }
}

TEST(Recognizer, DoesNotFindWhatIsNotThere) {
  const Scenery scenery;
  PointCloud ball;  // the near half of one
  for (int i = 0; i < 4000; ++i) {
    const double turn = 2.39996 * i, height = (i + 0.5) / 4000, r = std::sqrt(1 - height * height);
    ball.points.emplace_back(cv::Point3f(static_cast<float>(0.12 * r * std::cos(turn)),
                                         static_cast<float>(0.12 * r * std::sin(turn)),
                                         static_cast<float>(1.5 - 0.12 * height)));
  }
  for (const std::string preset : {"default", "classical", "thesis"})
    EXPECT_TRUE(findIn(RecognitionOptions::preset(preset), ball, scenery.scene).empty()) << preset;
}

TEST(Recognizer, ColorsTellThingsOfOneShapeApart) {
  Scenery red;
  red.scene.colors.assign(red.scene.points.size(), {128, 128, 128});
  std::fill_n(red.scene.colors.begin(), red.model.points.size(), cv::Vec3b(30, 30, 200));
  red.model.colors.assign(red.model.points.size(), {30, 30, 200});
  PointCloud blue = red.model;
  blue.colors.assign(blue.points.size(), {200, 60, 30});
  RecognitionOptions options;
  EXPECT_TRUE(isFound(findIn(options, blue, red.scene), red)) << "shape alone";
  options.colorTolerance = 20;
  EXPECT_TRUE(isFound(findIn(options, red.model, red.scene), red));
  EXPECT_TRUE(findIn(options, blue, red.scene).empty());
}

TEST(Recognizer, HolesAreLeftOut) {
  Scenery scenery;
  for (std::size_t i = 0; i < scenery.scene.points.size(); i += 7)
    scenery.scene.points[i].x = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < scenery.model.points.size(); i += 5)
    scenery.model.points[i].z = std::numeric_limits<float>::infinity();
  const auto found = findIn(RecognitionOptions::preset("default"), scenery.model, scenery.scene);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(cv::norm(found[0].pose.translation() - scenery.truth.translation()), 0.02);
}

TEST(Recognizer, CloudsAndLengthsInDifferentUnitsAreNoticed) {
  const Scenery meters, centimeters(100), millimeters(1000);
  const auto refusal = [](const RecognitionOptions& options, const Scenery& model, const Scenery& scene) {
    return test::caught([&] { findIn(options, model.model, scene.scene); });
  };
  const auto options = RecognitionOptions::preset("default");
  EXPECT_THAT(refusal(options, millimeters, meters),
              FailsWith(ErrorCode::mismatch, "model", "scene", "--object-unit"));
  EXPECT_THAT(refusal(options, meters, millimeters), FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refusal(RecognitionOptions::preset("classical"), meters, centimeters),
              FailsWith(ErrorCode::mismatch));
  for (double RecognitionOptions::*length :
       {&RecognitionOptions::descriptorRadius, &RecognitionOptions::normalRadius}) {
    RecognitionOptions inMillimeters = options;
    inMillimeters.*length = 25;
    EXPECT_THAT(refusal(inMillimeters, meters, meters), FailsWith(ErrorCode::mismatch));
  }
}

TEST(Recognizer, UselessCloudsAreErrorsOrGiveNothing) {
  const Scenery scenery;
  const Recognizer recognizer;
  PointCloud one, holes, same;
  one.points = {{1, 2, 3}};
  holes.points.assign(100, cv::Point3f(std::nanf(""), 0, 0));
  same.points.assign(1000, cv::Point3f(1, 2, 3));
  for (const PointCloud& cloud : {PointCloud(), one, holes, same}) {
    const ErrorCode code = cloud.points.size() < 1000 ? ErrorCode::insufficientData : ErrorCode::invalidInput;
    EXPECT_THAT([&] { recognizer.prepareScene("useless", cloud); }, FailsWith(code));
    const test::Caught asModel = test::caught([&] {
      recognizer.find(*recognizer.prepareModel("useless", cloud),
                      *recognizer.prepareScene("scene", scenery.scene));
    });
    EXPECT_TRUE(asModel.code && asModel.message.find("useless") != std::string::npos) << asModel;
  }
  PointCloud projected = scenery.scene, few;
  for (cv::Point3f& p : projected.points) p += cv::Point3f(5e5F, 4.5e6F, 100);
  EXPECT_THAT([&] { recognizer.prepareScene("too coarse", projected); }, FailsWith(ErrorCode::invalidInput));
  for (int i = 0; i < 20; ++i) few.points.emplace_back(0.1F * static_cast<float>(i), 0.F, 1.F);
  EXPECT_THAT([&] { recognizer.prepareScene("line", few); }, FailsWith(ErrorCode::insufficientData));
  PointCloud plane;
  for (int i = 0; i < 25600; ++i)
    plane.points.emplace_back(0.0025F * static_cast<float>(i % 160), 0.0025F * static_cast<float>(i / 160),
                              1.F);
  EXPECT_TRUE(findIn(RecognitionOptions::preset("default"), scenery.model, plane).empty());
  EXPECT_THAT([&] { findIn({}, plane, scenery.scene); }, FailsWith(ErrorCode::invalidInput))
      << "it has no pose";
  PointCloud twice = scenery.scene;
  twice.points.insert(twice.points.end(), scenery.scene.points.begin(), scenery.scene.points.end());
  EXPECT_TRUE(isFound(findIn(RecognitionOptions::preset("default"), scenery.model, twice), scenery));
}

TEST(Recognizer, PointsAtTheSensorWereNotMeasured) {
  const Scenery scenery;
  PointCloud zeros = scenery.scene;
  // many drivers write these
  zeros.points.insert(zeros.points.end(), 2 * zeros.points.size(), cv::Point3f());
  EXPECT_TRUE(isFound(findIn(RecognitionOptions::preset("default"), scenery.model, zeros), scenery));
}

TEST(Recognizer, AModelLargerThanTheSceneIsNotFound) {
  const Scenery scenery;
  EXPECT_TRUE(findIn(RecognitionOptions::preset("default"), test::wavySheet(200, 1), scenery.model).empty());
}

TEST(Recognizer, AViewpointElsewhereChangesNothing) {
  const Scenery scenery;
  const cv::Affine3d elsewhere(cv::Vec3d(0.3, 1, -2), cv::Vec3d(3, -1, 2));
  RecognitionOptions options = RecognitionOptions::preset("default");
  options.viewpoint = elsewhere * cv::Point3d(0, 0, 0);
  const auto found = findIn(options, scenery.model, test::moved(scenery.scene, elsewhere));
  Scenery moved = scenery;
  moved.truth = elsewhere * scenery.truth;
  EXPECT_TRUE(isFound(found, moved));
  options.viewpoint.reset();
  PointCloud says = test::moved(scenery.scene, elsewhere);
  says.viewpoint = poseOf(elsewhere);
  EXPECT_TRUE(isFound(findIn(options, scenery.model, says), moved));
  options.viewpoint = cv::Point3d(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  EXPECT_THAT([&] { findIn(options, scenery.model, scenery.scene); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Recognizer, RefusesOptionsThatMakeNoSense) {
  const auto refused = [](auto&& change) {
    RecognitionOptions options;
    change(options);
    return test::caught([&] { const Recognizer recognizer(options); });
  };
  using Change = void (*)(RecognitionOptions&);
  const Change names[] = {
      [](auto& o) { o.keypoints = "sift"; },          [](auto& o) { o.descriptor = "sift"; },
      [](auto& o) { o.grouping = "ransac"; },         [](auto& o) { o.verification = "none"; },
      [](auto& o) { o.matchEach = "both"; },          [](auto& o) { o.surface = "rough"; },
      [](auto& o) { o.sceneFilter.method = "sieve"; }};
  for (std::size_t i = 0; i < std::size(names); ++i)
    EXPECT_THAT(refused(names[i]), FailsWith(ErrorCode::unknownName)) << i;
  const Change values[] = {
      [](auto& o) { o.normalRadius = -1; },   [](auto& o) { o.normalRadius = 0.01, o.normalNeighbors = 10; },
      [](auto& o) { o.matchDistance = -1; },  [](auto& o) { o.sceneKeypointSpacing = -1; },
      [](auto& o) { o.neighbors = 0; },       [](auto& o) { o.maxHypotheses = 0; },
      [](auto& o) { o.accept = 2; },          [](auto& o) { o.colorTolerance = -1; },
      [](auto& o) { o.colorTolerance = 301; }};
  for (std::size_t i = 0; i < std::size(values); ++i)
    EXPECT_THAT(refused(values[i]), FailsWith(ErrorCode::invalidOption)) << i;
  EXPECT_THAT(
      [] { RecognitionOptions::preset("best"); },
      FailsWith(ErrorCode::unknownName, "best", "default, classical, thesis, author-2014, tight, wide"));
}

/// All options with their paths, as text.
void list(const OptionGroup& group, const std::string& path, std::map<std::string, std::string>& texts) {
  for (const Option& option : group.options()) texts[path + option.name()] = option.text();
  for (const OptionGroup& inner : group.groups()) list(inner, path + inner.name() + ".", texts);
}

std::map<std::string, std::string> textsOf(RecognitionOptions options) {
  std::map<std::string, std::string> texts;
  list(declare(options), "", texts);
  return texts;
}

TEST(RecognitionOptions, AreByDefaultTheDefaultPreset) {
  EXPECT_EQ(textsOf({}), textsOf(RecognitionOptions::preset("default")));
  EXPECT_EQ(RecognitionOptions().sceneFilter.gng.signalsPerInsertion, 25U);
  EXPECT_EQ(RecognitionOptions().modelFilter.gng.signalsPerInsertion, 2000U);
}

TEST(RecognitionOptions, AViewpointIsThreeNumbers) {
  RecognitionOptions options;
  OptionGroup group = declare(options);
  group.set("viewpoint", "1,-2.5,3e-1");
  EXPECT_EQ(*options.viewpoint, cv::Point3d(1, -2.5, 0.3));
  EXPECT_EQ(group.find("viewpoint")->text(), "1,-2.5,0.3");
  group.set("viewpoint", "");
  EXPECT_FALSE(options.viewpoint);
  for (const char* text : {"1,2", "1,2,3,4", "1 2 3", "x,y,z"})
    EXPECT_THAT([&] { group.set("viewpoint", text); }, FailsWith(ErrorCode::invalidOption));
}

TEST(Recognizer, DetectsAllModelsThatItKnows) {
  const Scenery scenery;
  Recognizer recognizer;
  EXPECT_TRUE(recognizer.detect(scenery.scene).empty());
  recognizer.addModel("model", scenery.model);
  recognizer.addModel("again", scenery.model);
  const auto found = recognizer.detect(scenery.scene);
  EXPECT_TRUE(isFound(found, scenery));
  std::set<std::string> names;
  for (const Detection& detection : found) names.insert(detection.model);
  EXPECT_THAT(names, testing::ElementsAre("model")) << "what one instance explains does not support another";
  EXPECT_EQ(found[0].pose.matrix, findIn({}, scenery.model, scenery.scene)[0].pose.matrix);

  RecognitionOptions stricter;
  stricter.falseAlarmRate = found[0].falseAlarmRate / 2;
  Recognizer strict(stricter);
  strict.addModel("model", scenery.model);
  std::vector<Detection> maybe;
  EXPECT_TRUE(strict.detect(scenery.scene, Progress::none(), &maybe).empty());
  EXPECT_TRUE(isFound(maybe, scenery)) << "what is not sure";
}

TEST(Recognizer, SeveralViewsInOneCloudAreNoView) {
  const Scenery scenery;
  RecognitionOptions options;
  declare(options).set("viewpoint", "none");
  EXPECT_TRUE(options.noView);
  EXPECT_EQ(declare(options).texts().at("viewpoint"), "none");
  const auto scene = Recognizer(options).prepareScene("scene", scenery.scene);
  EXPECT_FALSE(scene->hasView());
  EXPECT_FALSE(scene->estimatedViewpoint());
  EXPECT_TRUE(isFound(findIn(options, scenery.model, scenery.scene), scenery));
  declare(options).set("viewpoint", "0,0,0");
  EXPECT_TRUE(Recognizer(options).prepareScene("scene", scenery.scene)->hasView());
}

TEST(ObjectSearch, ABadModelCostsOnlyItself) {
  const Scenery scenery;
  const test::ScratchFolder folder;
  writeCloud(scenery.model, folder / "wave.ply");
  const Recognizer recognizer;
  const auto search = [&](const std::vector<std::string>& words) {
    return searchScene(recognizer, "scene", scenery.scene, modelFilesOf(words));
  };
  const std::string missing = folder / "missing.ply";
  const SearchResult result = search({missing, "model=" + (folder / "wave.ply").string()});
  EXPECT_TRUE(isFound(result.detections, scenery));
  EXPECT_EQ(result.model("model").cloud.points.size(), scenery.model.points.size());
  EXPECT_FALSE(result.model("model").stages.empty());
  ASSERT_EQ(result.failed.size(), 1U);
  EXPECT_EQ(result.failed[0].first, "missing");
  const auto json = toJson(result);
  EXPECT_EQ(json["instances"][0]["model"], "model");
  EXPECT_EQ(json["instances"][0]["pose"].size(), 16U);
  EXPECT_NEAR(json["instances"][0]["pose"][3].get<double>(), result.detections[0].pose.translation()[0],
              1e-12);
  EXPECT_EQ(json["failed"][0]["model"], "missing");
  EXPECT_TRUE(stagesJson(result)["models"].contains("model"));
  EXPECT_THAT([&] { search({missing}); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { search({missing, "b=" + missing}); }, FailsWith(ErrorCode::invalidInput));
}

TEST(ObjectSearch, ModelsAreNamedByFileOrByWord) {
  const auto files = modelFilesOf({"a/mug.pcd", "box=b/front.ply"});
  EXPECT_EQ(files[0].name, "mug");
  EXPECT_EQ(files[1].name, "box");
  EXPECT_EQ(files[1].cloud, "b/front.ply");
  EXPECT_THAT([] { modelFilesOf({"a/mug.pcd", "b/mug.ply"}); }, FailsWith(ErrorCode::invalidOption));
}

TEST(PreparedModel, ALargeOneIsTriedWithAPartOfItsPoints) {
  const Recognizer recognizer;
  const PointCloud sheet = test::wavySheet(300, 1);
  const auto scene = recognizer.prepareScene("scene", sheet);
  const auto model = recognizer.prepareModel("model", sheet);
  const auto described = model->describedFor(scene->scalesFor(*model));
  EXPECT_LE(described->features.size(), 1000U);
  EXPECT_EQ(described->dense.fine.points.size(), 1000U);
  EXPECT_EQ(described->dense.coarse.points.size(), 300U);
  EXPECT_GT(described->dense.area, 1500U);
  for (const OrientedPoints* part : {&described->dense.fine, &described->dense.coarse})
    EXPECT_LT(cv::norm(meanOf(part->points) - model->center()), 0.03) << "from everywhere";
  const auto found = recognizer.find(*model, *scene);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT(cv::norm(found[0].pose.translation()), 0.005);
}

}  // namespace
}  // namespace estancia
