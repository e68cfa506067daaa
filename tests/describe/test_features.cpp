// What views are described by: shapes (ESF), and features of sequences and of tables.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <opencv2/core.hpp>
#include <random>
#include <thread>

#ifdef ESTANCIA_HAS_PCL
#include <pcl/features/esf.h>
#include <pcl/point_types.h>
#endif

#include "describe/made_up_sequence.hpp"
#include "estancia/describe/esf.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/describe/phog.hpp"
#include "estancia/describe/table_features.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/model_support.hpp"

#ifdef ESTANCIA_HAS_PCL
namespace {
unsigned pclSeed = 1;
}
/// PCL starts its random numbers with the second that it is run in; here they are different in every run, and
/// the same in every test: the program's own srand stands before the C library's.
extern "C" void srand(unsigned) noexcept {
  srandom(pclSeed);
}
#endif

namespace estancia {
namespace {

using test::busyImage;
using test::FailsWith;
using test::MadeUpSequence;
using testing::ElementsAre;

class DescribeSequence : public testing::Test {
 protected:
  DescribeSequence() {
    for (unsigned i = 0; i < 6; ++i) sequence_.add(busyImage({64, 48}, i));
  }

  std::string model(const std::string& name) {
    test::writeSmallModel(scratch_ / name);
    const auto toml = scratch_ / name / "model.toml";
    std::string text = test::readFile(toml);
    const auto at = text.find("name = \"") + 8;
    text.replace(at, text.find('"', at) - at, name);
    test::writeFile(toml, text);
    return (scratch_ / name).string();
  }
  Features describe(const std::string& descriptors, int threads = 1) {
    DescribeOptions options;
    options.labeler.threads = threads;
    problems_.clear();
    return describeSequence(sequence_, descriptors, options, Progress::none(), &problems_);
  }

  test::ScratchFolder scratch_;
  MadeUpSequence sequence_;
  std::vector<std::string> problems_;
};

TEST_F(DescribeSequence, GivesEveryNameItsOwnPart) {
  const std::string a = model("a"), b = model("b");
  const Features features = describe(a + "+phog+" + b);
  EXPECT_EQ(features.name(), "a+phog+b");
  ASSERT_EQ(features.frames.size(), 6U);
  EXPECT_EQ(features.frames[1].name, "0001.png");
  EXPECT_EQ(features.frames[1].room, "office");
  EXPECT_EQ(features.values.size(), 6U);
  EXPECT_EQ(features.values.labels(), 4U + 630U + 4U);
  EXPECT_EQ(features.parts[0].kind, PartKind::probabilities);
  EXPECT_EQ(features.parts[0].identity, loadModel(a)->identity());
  EXPECT_EQ(features.parts[0].columns, loadModel(a)->vocabulary().labels());
  EXPECT_EQ(features.parts[1], Phog().parts().front());
  EXPECT_THAT(problems_, testing::IsEmpty());
  EXPECT_EQ(describe(a + "+phog+" + b, 5).values.values(), features.values.values()) << "with any threads";

  const auto labeler = loadModel(b);
  for (std::size_t i = 0; i < 6; ++i) {
    const DescriptorView row = features.values.row(i);
    const std::vector<float> edges = phog(sequence_.image(i)), words = labeler->label(sequence_.image(i));
    EXPECT_TRUE(std::equal(edges.begin(), edges.end(), row.begin() + 4));
    EXPECT_TRUE(std::equal(words.begin(), words.end(), row.begin() + 634));
  }
}

TEST_F(DescribeSequence, OneViewHasTheSameNumbersWhoeverAsks) {
  const std::string names = model("a") + "+phog";
  const Features all = describe(names);
  const auto descriptor = loadDescriptor(names);
  EXPECT_EQ(descriptor->parts(), all.parts);
  EXPECT_TRUE(descriptor->needsImage());
  EXPECT_FALSE(descriptor->needsDepth());
  EXPECT_TRUE(loadDescriptor("phog+esf")->needsDepth());
  std::vector<std::vector<float>> rows(all.frames.size());
  std::vector<std::thread> robots;
  for (std::size_t i = 0; i < rows.size(); ++i)
    robots.emplace_back([&, i] {
      const Features one = featuresOf(*descriptor, {.image = sequence_.image(i), .frame = "now"});
      EXPECT_EQ(one.frames.at(0).name, "now");
      rows[i] = one.values.values();
    });
  for (std::thread& robot : robots) robot.join();
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_TRUE(std::ranges::equal(rows[i], all.values.row(i))) << "view " << i;
  EXPECT_THAT([&] { featuresOf(*descriptor, View{}); }, FailsWith(ErrorCode::invalidInput));
}

TEST_F(DescribeSequence, LeavesOutFramesThatCannotBeDescribedAndTellsWhy) {
  sequence_.add({});
  sequence_.add(busyImage({64, 48}, 9));
  const Features features = describe("phog+" + model("a"));
  ASSERT_EQ(features.frames.size(), 7U);
  EXPECT_EQ(features.frames[6].name, "0007.png");
  EXPECT_THAT(problems_, ElementsAre("0006.png: cannot be read"));
  sequence_.add(cv::Mat(20, 20, CV_8UC2));  // OpenCV's own exception
  EXPECT_EQ(describe("phog").frames.size(), 7U);
  EXPECT_THAT(problems_, ElementsAre(testing::_, testing::StartsWith("0008.png")));
}

TEST_F(DescribeSequence, RefusesWhatItCannotDo) {
  EXPECT_THAT([&] { describe("phgo"); }, FailsWith(ErrorCode::unknownName));
  const std::string a = model("a");
  for (const std::string& names :
       {std::string("phog+phog"), std::string("phog+"), std::string(), a + "+" + a + "/"})
    EXPECT_THAT([&] { describe(names); }, FailsWith(ErrorCode::invalidOption)) << names;
  MadeUpSequence unreadable;
  unreadable.add({});
  EXPECT_THAT([&] { describeSequence(unreadable, "phog"); }, FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { describeSequence(MadeUpSequence(), "phog"); }, FailsWith(ErrorCode::insufficientData));
}

TEST_F(DescribeSequence, ShapesNeedDepthAndItsCamera) {
  const auto refusal = [&] { describeSequence(sequence_, "phog+esf"); };
  EXPECT_THAT(refusal, FailsWith(ErrorCode::invalidInput));
  cv::Mat depth;
  busyImage({64, 48}, 3, 1).convertTo(depth, CV_32F, 0.01, 1);
  sequence_.add(busyImage({64, 48}, 7), depth);
  EXPECT_THAT(refusal, FailsWith(ErrorCode::invalidInput));
  sequence_.setCamera({128, 96, 100, 100, 64, 48});
  const Features features = describe("phog+esf");
  ASSERT_EQ(features.frames.size(), 1U) << "the others have no depth";
  EXPECT_EQ(problems_.size(), 6U);
  const View view{
      .image = sequence_.image(6), .depth = depth, .camera = sequence_.intrinsics()->scaledTo(64, 48)};
  EXPECT_EQ(features.values.values(), featuresOf(*loadDescriptor("phog+esf"), view).values.values());
}

TEST_F(DescribeSequence, GivesAllFramesTheWordsThatAreDiscovered) {
  test::writeFile(scratch_ / "discover/model.toml", R"(name = "discover"
type = "process"
command = ["sh", "-c", 'n=0; while read -r image; do n=$((n+1)); echo "{\"image\": \"$image\", \"labels\": {\"word $n\": 0.5}}"; done']
)");
  const Features features = describe((scratch_ / "discover").string());
  ASSERT_EQ(features.parts.size(), 1U);
  EXPECT_EQ(features.parts[0].size(), 6U);
  EXPECT_EQ(features.values.labels(), 6U);
  EXPECT_FLOAT_EQ(features.values.row(0)[0], 0.5F);
  EXPECT_FLOAT_EQ(features.values.row(0)[5], 0);
  EXPECT_FLOAT_EQ(features.values.row(5)[5], 0.5F);
}

TEST_F(DescribeSequence, WordsOfARecordingAreOnePartAModel) {
  const std::string a = model("a"), b = model("b");
  const auto both = loadModel(a + "+" + b);
  const Features recorded = featuresOf(record(sequence_, *both));
  const Features described = describe(a + "+" + b);
  EXPECT_EQ(recorded.name(), "a+b");
  EXPECT_EQ(recorded.values.values(), described.values.values());
  EXPECT_EQ(recorded.parts[1].columns, described.parts[1].columns);

  const auto single = loadModel(a);
  EXPECT_EQ(featuresOf(record(sequence_, *single)).parts, describe(a).parts);
}

TEST_F(DescribeSequence, PartsAndRowsAreTakenInTheOrderGiven) {
  const Features all = describe(model("a") + "+phog");
  const Features turned = withParts(all, {"phog", "a"});
  EXPECT_EQ(turned.name(), "phog+a");
  EXPECT_EQ(turned.values.labels(), 634U);
  EXPECT_EQ(turned.values.row(3)[630], all.values.row(3)[0]);
  EXPECT_EQ(turned.values.row(3)[0], all.values.row(3)[4]);
  EXPECT_THAT([&] { withParts(all, {"gist"}); }, FailsWith(ErrorCode::unknownName));

  const Features rows = withRows(all, {5, 0});
  ASSERT_EQ(rows.frames.size(), 2U);
  EXPECT_EQ(rows.frames[0].name, "0005.png");
  EXPECT_EQ(rows.values.row(1)[7], all.values.row(0)[7]);
  EXPECT_THAT([&] { withRows(all, {6}); }, FailsWith(ErrorCode::invalidInput));
}

Features featuresOfText(const std::string& text) {
  const test::ScratchFolder folder;
  test::writeFile(folder / "f.csv", text);
  return featuresOf(readFeatureTable(folder / "f.csv"));
}

PartKind kindOf(const std::string& first, const std::string& second) {
  return featuresOfText("room,h0,h1,h2\nhall," + first + "\noffice," + second + "\n").parts.at(0).kind;
}

TEST(TableFeatures, ConstantSumsAreHistograms) {
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0,1"), PartKind::histogram);
  EXPECT_EQ(kindOf("50,25,25", "0,99.99,0"), PartKind::histogram) << "rounding is no difference";
  EXPECT_EQ(kindOf("0,0,0", "0,0,1"), PartKind::histogram) << "nothing was counted";
  EXPECT_EQ(kindOf("0.5,0.25,0.25", "0,0.5,0"), PartKind::energies);
  EXPECT_EQ(kindOf("-0.5,1.25,0.25", "0,0,1"), PartKind::energies);
  EXPECT_EQ(kindOf("0,0,0", "0,0,0"), PartKind::energies);
  EXPECT_EQ(kindOf("1,2,3", "1,2,3"), PartKind::energies) << "constants may be below 0 elsewhere";
}

TEST(TableFeatures, ASingleColumnIsNoHistogram) {
  const Features features = featuresOfText("room,height,h0,h1\nhall,1,0.5,0.5\noffice,1,0,1\n");
  ASSERT_EQ(features.parts.size(), 2U);
  EXPECT_EQ(features.parts[0].kind, PartKind::energies);
  EXPECT_EQ(features.parts[1].kind, PartKind::histogram);
  EXPECT_THAT(features.parts[1].columns, ElementsAre("h0", "h1"));
  EXPECT_EQ(features.frames[1].room, "office");
  EXPECT_THAT(features.values.row(1), ElementsAre(1, 0, 1));
}

TEST(TableFeatures, TablesOfTheSameColumnsFitEachOther) {
  const auto parts = featuresOfText("room,h0,h1\nhall,1,0\n").parts;
  EXPECT_EQ(featuresOfText("image,h0,h1,room\na,0.5,0.5,office\n").parts, parts);
  EXPECT_NE(featuresOfText("room,h0,h1,h2\nhall,1,0,0\n").parts[0].identity, parts[0].identity);
}

TEST(TableFeatures, ColumnsOfZeroAndOneAreBinary) {
  const Features features = featuresOfText("room,Chair,g0,g1,Desk,size\nhall,1,1,0,0,1\nlab,0,0,1,0,2\n");
  EXPECT_THAT(binaryParts(features), ElementsAre("Chair", "Desk")) << "g has two columns, size a 2";
}

TEST(TableFeatures, AreSelectedByRoomAndCountedByRoom) {
  const Features features = featuresOfText("room,g0,g1\nhall,1,0\nlab,0,1\nhall,3,0\n");
  EXPECT_EQ(framesPerRoom(features), (std::map<std::string, std::size_t>{{"hall", 2}, {"lab", 1}}));
  const Features hall = withRooms(features, {"hall"});
  ASSERT_EQ(hall.frames.size(), 2U);
  EXPECT_THAT(hall.values.row(1), ElementsAre(3, 0));
  EXPECT_EQ(withRooms(features, {}).frames.size(), 3U);
  EXPECT_THAT([&] { withRooms(features, {"lab", "garage"}); }, test::FailsWith(ErrorCode::unknownName));
}

const CameraIntrinsics kCamera{320, 240, 290, 290, 159.5, 119.5};
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// The surface of a bent sheet with a ball on it.
PointCloud sheetAndBall(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::normal_distribution<float> normal;
  PointCloud cloud;
  while (cloud.points.size() < count) {
    const float x = uniform(random), y = uniform(random);
    cloud.points.emplace_back(x, y, 0.3F * x * x);
    const cv::Point3f d(normal(random), normal(random), normal(random));
    cloud.points.push_back(d * (0.4F / std::sqrt(d.dot(d))) + cv::Point3f(0.2F, 0.1F, 0.8F));
  }
  cloud.width = cloud.points.size();
  cloud.height = 1;
  return cloud;
}

PointCloud moved(PointCloud cloud, float scale, cv::Point3f by = {}) {
  for (cv::Point3f& p : cloud.points) p = p * scale + by;
  return cloud;
}

double overlap(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::min(a[i], b[i]);
  return sum;
}

TEST(Esf, TheSameSeedGivesTheSameBytesInAnyThread) {
  const PointCloud cloud = sheetAndBall(30000, 2);  // thinned, too
  const auto once = esf(cloud, {.seed = 7});
  std::vector<std::vector<float>> results(6);
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = esf(cloud, {.seed = 7}); });
  }
  for (const auto& result : results) EXPECT_EQ(result, once);
  EXPECT_NE(esf(cloud, {.seed = 8}), once);
  EXPECT_GT(overlap(esf(cloud, {.seed = 8}), once), 0.93);
}

TEST(Esf, UnitAndPlaceDoNotCount) {
  const PointCloud meters = sheetAndBall(8000, 3);
  const auto v = esf(meters);
  ASSERT_EQ(v.size(), 640U);
  EXPECT_NEAR(std::accumulate(v.begin(), v.end(), 0.0), 1, 1e-4);
  // Powers of two change no bit of the points; thousands round some over a limit.
  EXPECT_EQ(esf(moved(meters, 1024)), v);
  EXPECT_GT(overlap(esf(moved(meters, 1000)), v), 0.999);
  EXPECT_GT(overlap(esf(moved(meters, 1e-3F)), v), 0.999);
  EXPECT_GT(overlap(esf(moved(meters, 1, {5, -3, 9})), v), 0.995);
}

TEST(Esf, RefusesWhatHasNoShape) {
  PointCloud line, slanted;
  for (int i = 0; i < 500; ++i) {
    line.points.emplace_back(static_cast<float>(i), 0.0F, 1.0F);
    slanted.points.push_back(cv::Point3f(3, -7, 11) * static_cast<float>(i));
  }
  PointCloud pair{std::vector<cv::Point3f>(5000, {0, 0, 0}), {}, {}, 5002, 1};
  pair.points.push_back({1, 0, 0});
  pair.points.push_back({0, 1, 0});
  const PointCloud clouds[] = {{},
                               {{{0, 0, 0}, {1, 0, 0}}, {}, {}, 2, 1},
                               {{{0, 0, 0}, {1, 0, 0}, {nan, 1, 1}}, {}, {}, 3, 1},
                               {std::vector<cv::Point3f>(500, {1, 2, 3}), {}, {}, 500, 1},
                               line,
                               slanted,
                               pair};
  for (const PointCloud& cloud : clouds)
    EXPECT_THAT([&] { esf(cloud); }, FailsWith(ErrorCode::insufficientData)) << cloud.points.size();
  const PointCloud cloud = sheetAndBall(100, 8);
  EXPECT_THAT([&] { esf(cloud, {.samples = 0}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_THAT([&] { esf(cloud, {.points = 2}); }, FailsWith(ErrorCode::invalidOption));
  EXPECT_EQ(esf({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}, 3, 1}).size(), 640U) << "three are enough";
}

cv::Mat roomDepth(std::uint64_t seed) {
  cv::Mat depth(240, 320, CV_32F);
  cv::RNG random(seed);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const double floor = y > 120 ? 1.4 / kCamera.slopeY(y) : 1e9;
      const bool box = x > 100 && x < 180 && y > 90 && y < 190;
      depth.at<float>(y, x) =
          static_cast<float>(std::min({3.0, floor, box ? 1.8 : 1e9}) + random.gaussian(0.005));
    }
  return depth;
}

TEST(Esf, DescribesAView) {
  View view{{}, roomDepth(1), kCamera, "a"};
  const auto v = Esf().describe(view);
  EXPECT_EQ(v, esf(backProject(view.depth, kCamera)));
  view.depth.rowRange(0, 5).setTo(0);
  view.depth.rowRange(5, 9).setTo(nan);
  EXPECT_GT(overlap(Esf().describe(view), v), 0.9);

  view.depth = cv::Mat::zeros(240, 320, CV_32F);
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::insufficientData));
  view.depth = roomDepth(1);
  view.camera.reset();
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::invalidInput));
  view.depth.release();
  EXPECT_THAT([&] { Esf().describe(view); }, FailsWith(ErrorCode::invalidInput));
}

TEST(BackProjection, PutsPixelsWhereTheCameraSawThem) {
  cv::Mat depth = cv::Mat::zeros(2, 3, CV_32F);
  depth.at<float>(1, 2) = 2;
  depth.at<float>(0, 0) = -1;
  depth.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  const PointCloud cloud = backProject(depth, {3, 2, 10, 20, 1, 0.5});
  EXPECT_TRUE(cloud.organized());
  ASSERT_EQ(cloud.points.size(), 6U);
  EXPECT_EQ(cloud.width, 3U);
  EXPECT_FLOAT_EQ(cloud.points[5].x, 0.2F);
  EXPECT_FLOAT_EQ(cloud.points[5].y, 0.05F);
  EXPECT_FLOAT_EQ(cloud.points[5].z, 2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(std::isnan(cloud.points[static_cast<std::size_t>(i)].z));
  EXPECT_THAT([&] { backProject({}, kCamera); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { backProject(cv::Mat(2, 2, CV_16U), kCamera); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { backProject(depth, {}); }, FailsWith(ErrorCode::invalidInput));
}

#ifdef ESTANCIA_HAS_PCL
std::vector<float> pclEsf(const PointCloud& cloud, unsigned run) {
  pclSeed = run + 1;
  const auto input = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const cv::Point3f& p : cloud.points) input->emplace_back(p.x, p.y, p.z);
  pcl::ESFEstimation<pcl::PointXYZ> estimation;
  estimation.setInputCloud(input);
  pcl::PointCloud<pcl::ESFSignature640> output;
  estimation.compute(output);
  return {output[0].histogram, output[0].histogram + 640};
}

struct Moments {
  std::vector<double> mean = std::vector<double>(640), variance = std::vector<double>(640);

  explicit Moments(const std::vector<std::vector<float>>& runs) {
    const auto n = static_cast<double>(runs.size());
    for (std::size_t i = 0; i < 640; ++i) {
      for (const auto& run : runs) mean[i] += run[i] / n;
      for (const auto& run : runs) variance[i] += (run[i] - mean[i]) * (run[i] - mean[i]) / (n - 1);
    }
  }
};

/// Welch's test in every bin. A |t| of 8 with 80 degrees of freedom happens once in 10^11 by chance, so that
/// the 640 bins never fail without a reason; the mean of t² is 1 by chance, and above 2 when
/// bins differ by as little as half a standard deviation of one run.
void expectSameDistribution(const PointCloud& cloud) {
  constexpr unsigned runs = 48;
  std::vector<std::vector<float>> ours, theirs;
  for (unsigned run = 0; run < runs; ++run) {
    ours.push_back(esf(cloud, {.points = 0, .seed = run + 1}));
    theirs.push_back(pclEsf(cloud, run));
  }
  const Moments a(ours), b(theirs);
  double sum = 0;
  int tested = 0;
  for (std::size_t i = 0; i < 640; ++i) {
    // About 120,000 counts: a bin with less than a dozen is no normal distribution.
    if (std::max(a.mean[i], b.mean[i]) < 1e-4) {
      EXPECT_NEAR(a.mean[i], b.mean[i], 1e-4) << i;
      continue;
    }
    const double t = (a.mean[i] - b.mean[i]) / std::sqrt((a.variance[i] + b.variance[i]) / runs);
    EXPECT_LT(std::abs(t), 8) << "bin " << i << ": " << a.mean[i] << " and " << b.mean[i];
    sum += t * t;
    ++tested;
  }
  EXPECT_GT(tested, 150);
  EXPECT_LT(sum / tested, 2);
}

TEST(EsfAsPcl, OfAMadeUpCloud) {
  expectSameDistribution(sheetAndBall(6000, 9));
}

#endif

}  // namespace
}  // namespace estancia
