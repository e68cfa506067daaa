// Where a robot is: places by single images and by the drive, and how views are compared.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/localization/localizer.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <random>

#include "estancia/distances/distance.hpp"
#include "estancia/localization/localization_filter.hpp"
#include "estancia/localization/localizer_map.hpp"
#include "estancia/localization/view_metric.hpp"
#include "support/errors.hpp"
#include "support/synthetic.hpp"

namespace estancia {
namespace {

using Matrix = std::vector<std::vector<double>>;

PlaceFilter makeFilter(std::size_t images = 9) {
  std::vector<std::size_t> nodeOf(images);
  for (std::size_t i = 0; i < images; ++i) nodeOf[i] = i * 3 / images;
  return PlaceFilter(nodeOf, 4, {{0, 1}, {1, 2}, {2, 1}}, {});  // node 3 has no images
}

/// T(i, j) by pushing each unit vector through predict().
Matrix transitionMatrix(const PlaceFilter& filter) {
  const std::size_t n = filter.states();
  Matrix t(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<float> in(n, 0.0F), out(n);
    in[i] = 1;
    filter.predict(in, {}, out);
    for (std::size_t j = 0; j < n; ++j) t[i][j] = out[j];
  }
  return t;
}

TEST(PlaceFilter, PredictionKeepsAllProbabilityAndBackwardIsItsTranspose) {
  const PlaceFilter filter = makeFilter();
  const Matrix t = transitionMatrix(filter);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform;
  std::vector<float> in(filter.states()), out(filter.states());
  for (float& v : in) v = uniform(random);
  filter.backward(in, {}, out);
  for (std::size_t i = 0; i < t.size(); ++i) {
    EXPECT_NEAR(std::accumulate(t[i].begin(), t[i].end(), 0.0), 1, 1e-5);
    EXPECT_GT(*std::min_element(t[i].begin(), t[i].end()), 0);  // anything may happen
    double expected = 0;
    for (std::size_t j = 0; j < t.size(); ++j) expected += t[i][j] * in[j];
    EXPECT_NEAR(out[i], expected, 1e-5);
  }
  EXPECT_GT(t[3][4], t[3][2]) << "driving on moves on";
}

TEST(PlaceFilter, LikelihoodIsLargestAtTheNearestAndFlatWithoutDifferences) {
  const PlaceFilter filter = makeFilter(4);
  const std::vector<float> distances{0.9F, 0.2F, 0.8F, 0.7F}, same(4, 0.5F);
  const auto likelihood = filter.likelihood(distances);
  EXPECT_EQ(likelihood[1], 1.0F);
  EXPECT_GT(likelihood[3], likelihood[2]);
  for (const float l : filter.likelihood(same)) EXPECT_EQ(l, 1.0F);
}

/// A map of one long corridor: image i shows place i; three images a node.
struct Corridor {
  explicit Corridor(double variation = 0.6, std::size_t places = 30) : world(places, 80, variation) {
    std::vector<std::string> names;
    for (int l = 0; l < 80; ++l) names.push_back("label " + std::to_string(l));
    map.vocabulary = Vocabulary(names);
    map.distance = "hellinger";
    bank = std::make_unique<NodeBank>(getDistance(map.distance), 80);
    for (std::size_t i = 0; i < places; ++i) {
      const auto image = world.image(i);
      images.append(image);
      MappedFrame frame;
      frame.name = std::to_string(i);
      frame.node = static_cast<int>(i / 3);
      map.frames.push_back(frame);
      std::vector<float> embedded(80);
      embed(Embedding::squareRoot, image, embedded);
      if (i % 3 == 0) {
        Node node;
        node.id = frame.node;
        map.nodes.push_back(node);
        if (i > 0) map.transitions.push_back({frame.node - 1, frame.node, 1, i});
        bank->add(bank->makeNode(frame.node));
      }
      bank->update(i / 3, [&](NodeMemory& node) {
        ++node.frames;
        node.probabilities.add(image);
        node.embedded->add(embedded);
      });
    }
  }
  std::shared_ptr<const LocalizerMap> source() const {
    return std::make_shared<LocalizerMap>(LocalizerMap{map, *bank, images, 1});
  }

  test::SyntheticPlaces world;
  TopologicalMap map{.vocabulary = Vocabulary({"x"})};
  std::unique_ptr<NodeBank> bank;
  DescriptorMatrix images{80};
};

std::vector<Localization> localized(const std::shared_ptr<const LocalizerMap>& source,
                                    const std::vector<std::vector<float>>& drive, std::size_t lookahead) {
  LocalizerOptions options;
  options.lookahead = lookahead;
  Localizer localizer(source, options);
  std::vector<Localization> answers;
  for (const auto& image : drive)
    for (const auto& answer : localizer.add(image)) answers.push_back(answer);
  for (const auto& answer : localizer.finish()) answers.push_back(answer);
  return answers;
}

double share(const std::vector<Localization>& answers, const std::vector<std::size_t>& truth, bool belief) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto at = static_cast<std::ptrdiff_t>(belief ? answers[i].beliefImage : answers[i].nearestImage);
    right += std::abs(at - static_cast<std::ptrdiff_t>(truth[i])) <= 1;
  }
  return static_cast<double>(right) / static_cast<double>(truth.size());
}

std::vector<std::size_t> forwards(std::size_t n = 30) {
  std::vector<std::size_t> way(n);
  std::iota(way.begin(), way.end(), 0U);
  return way;
}

TEST(Localizer, ClearImagesAreFoundAtOnce) {
  Corridor corridor(0.3);
  const auto truth = forwards();
  const auto answers = localized(corridor.source(), corridor.world.drive(truth, 1), 0);
  ASSERT_EQ(answers.size(), 30U);
  EXPECT_EQ(share(answers, truth, false), 1.0);
  for (std::size_t i = 0; i < truth.size(); ++i) EXPECT_EQ(answers[i].node, static_cast<int>(i / 3));
  EXPECT_GT(answers.back().confidence, 0.9);
  EXPECT_FALSE(answers.back().unmapped);
  EXPECT_FALSE(answers.back().beliefZone);
}

TEST(Localizer, TellsTheZoneThatItsFramesAreIn) {
  Corridor corridor(0.3);
  Localizer localizer(corridor.source(), {});
  EXPECT_THAT([&] { localizer.setZones({1, 2}); }, test::FailsWith(ErrorCode::mismatch));
  std::vector<int> zoneOf(30);
  for (std::size_t i = 0; i < 30; ++i) zoneOf[i] = i < 10 ? 7 : i < 20 ? -1 : 3;
  localizer.setZones(zoneOf);
  for (const std::size_t place : forwards()) {
    const Localization answer = localizer.add(corridor.world.image(place)).front();
    if (place % 10 > 2) {
      EXPECT_EQ(answer.beliefZone, zoneOf[place]) << place;
    }
    EXPECT_GE(answer.zoneConfidence, answer.confidence - 0.05);  // zones are wider than places here
    EXPECT_LE(answer.zoneConfidence, 1 + 1e-6);
  }
}

TEST(Localizer, TheDriveTellsWhatSingleImagesDoNot) {
  Corridor corridor(2.2, 60);  // images of a place hardly resemble each other
  for (const bool back : {false, true}) {
    auto truth = forwards(60);
    if (back) std::reverse(truth.begin(), truth.end());
    const auto drive = corridor.world.drive(truth, 1);
    const auto filtered = localized(corridor.source(), drive, 0);
    const auto smoothed = localized(corridor.source(), drive, 10);
    ASSERT_EQ(smoothed.size(), truth.size());
    EXPECT_LT(share(filtered, truth, false), 0.6) << "the test must be hard";
    EXPECT_GT(share(filtered, truth, true), share(filtered, truth, false) + 0.15) << back;
    EXPECT_GE(share(smoothed, truth, true), share(filtered, truth, true)) << back;
  }
}

TEST(Localizer, SmoothingEqualsForwardBackwardOverTheWholeDrive) {
  Corridor corridor(1.5, 9);
  const auto truth = forwards(9);
  const auto drive = corridor.world.drive(truth, 1);
  const auto smoothed =
      localized(corridor.source(), drive, 100);  // lookahead beyond the end: everything at once

  std::vector<std::size_t> nodeOf;
  for (const auto& frame : corridor.map.frames) nodeOf.push_back(static_cast<std::size_t>(frame.node));
  const PlaceFilter filter(nodeOf, 3, {{0, 1}, {1, 2}}, {});
  const Matrix t = transitionMatrix(filter);
  const std::size_t n = filter.states();
  std::vector<std::vector<double>> likelihoods, forward;
  std::vector<float> a(80), b(80);
  for (const auto& image : drive) {
    std::vector<float> distances;
    embed(Embedding::squareRoot, image, a);
    for (std::size_t i = 0; i < 9; ++i) {
      embed(Embedding::squareRoot, corridor.images.row(i), b);
      distances.push_back(static_cast<float>(compare(Comparison::euclidean, b, a)));
    }
    const auto l = filter.likelihood(distances);
    std::vector<double> perState(n);
    for (std::size_t s = 0; s < n; ++s) perState[s] = l[s % 9];
    likelihoods.push_back(perState);
  }
  std::vector<double> state(n, 1.0 / static_cast<double>(n));
  for (const auto& l : likelihoods) {
    std::vector<double> next(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) next[j] += state[i] * t[i][j];
    for (std::size_t s = 0; s < n; ++s) next[s] *= l[s];
    forward.push_back(state = next);
  }
  std::vector<double> backward(n, 1.0);
  for (std::size_t f = drive.size(); f-- > 0;) {
    std::vector<double> nodes(3, 0.0);
    double total = 0;
    for (std::size_t s = 0; s < n; ++s) {
      const double p = forward[f][s] * backward[s];
      nodes[nodeOf[s % 9]] += p;
      total += p;
    }
    const auto best = std::max_element(nodes.begin(), nodes.end());
    EXPECT_EQ(smoothed[f].beliefNode, best - nodes.begin()) << f;
    EXPECT_NEAR(smoothed[f].confidence, *best / total, 1e-3) << f;
    std::vector<double> before(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) before[i] += t[i][j] * likelihoods[f][j] * backward[j];
    backward = before;
  }
}

TEST(Localizer, AnEmptyMapIsAnError) {
  const auto empty =
      std::make_shared<LocalizerMap>(LocalizerMap{{.vocabulary = Vocabulary({"x"}), .distance = "hellinger"},
                                                  NodeBank(getDistance("hellinger"), 1),
                                                  DescriptorMatrix(1)});
  EXPECT_THAT([&] { Localizer(empty, {}); }, test::FailsWith(ErrorCode::insufficientData));
  LocalizerOptions none;
  none.maxImages = 0;
  EXPECT_THAT([&] { Localizer("no.estancia", none); }, test::FailsWith(ErrorCode::invalidOption));
}

constexpr std::size_t metricLabels = 24;
constexpr Neighborhoods::Reach metricReach{0.25, 10};

using Rows = std::vector<float>;

std::span<const float> rowOf(const Rows& rows, std::size_t i) {
  return std::span(rows).subspan(i * metricLabels, metricLabels);
}

void toUnit(Rows& rows) {
  for (std::size_t first = 0; first < rows.size(); first += metricLabels) {
    const std::span row(rows.data() + first, metricLabels);
    const float length = std::sqrt(dot(row, row));
    for (float& value : row) value /= length;
  }
}

/// `each` images of every place, 5 cm apart, places 5 m apart. What differs within a place are the first two
/// labels.
struct MetricDrive {
  explicit MetricDrive(std::size_t places = 12, std::size_t each = 6, unsigned seed = 1, float differs = 2) {
    std::mt19937 random(7), chance(seed);
    std::normal_distribution<float> normal;
    for (std::size_t place = 0; place < places; ++place) {
      Rows words(metricLabels);
      for (float& value : words) value = normal(random);
      for (std::size_t k = 0; k < each; ++k) {
        Rows image = words;
        for (std::size_t l = 0; l < metricLabels; ++l) image[l] += (l < 2 ? differs : 0.3F) * normal(chance);
        images.insert(images.end(), image.begin(), image.end());
        poses.push_back(Pose{.x = 5.0 * static_cast<double>(place) + 0.05 * static_cast<double>(k)});
      }
    }
    toUnit(images);
  }

  Rows images;
  std::vector<std::optional<Pose>> poses;
};

void expectWhole(const Neighborhoods& around) {
  for (std::size_t i = 0; i < around.size(); ++i) {
    double sum = 0;
    float own = 0, most = 0;
    for (const auto& [image, weight] : around.of(i)) {
      sum += weight;
      most = std::max(most, weight);
      if (image == i) own = weight;
    }
    EXPECT_NEAR(sum, 1, 1e-5) << i;
    EXPECT_FLOAT_EQ(own, most) << i;
  }
}

TEST(Neighborhoods, AreTheImagesTakenNear) {
  const MetricDrive drive;
  const Neighborhoods around(drive.images, drive.poses, metricReach);
  ASSERT_EQ(around.size(), 72U);
  expectWhole(around);
  std::size_t neighbors = 0;
  for (std::size_t i = 0; i < around.size(); ++i)
    for (const auto& [image, weight] : around.of(i)) {
      EXPECT_EQ(image / 6, i / 6);
      ++neighbors;
    }
  EXPECT_GT(neighbors, 72U * 5);

  MetricDrive turned;
  for (std::size_t i = 1; i < turned.poses.size(); i += 2) {  // by 90° about y
    turned.poses[i]->qy = std::sqrt(0.5);
    turned.poses[i]->qw = std::sqrt(0.5);
  }
  const Neighborhoods others(turned.images, turned.poses, metricReach);
  for (std::size_t i = 0; i < others.size(); ++i)
    for (const auto& [image, weight] : others.of(i)) EXPECT_EQ(image % 2, i % 2) << "looks another way";
}

TEST(Neighborhoods, OfACameraThatStandsAreBounded) {
  const Rows same(400 * metricLabels, 1 / std::sqrt(static_cast<float>(metricLabels)));
  for (const bool posed : {false, true}) {
    const std::vector<std::optional<Pose>> poses(400, posed ? std::optional(Pose{}) : std::nullopt);
    const Neighborhoods around(same, poses, metricReach);
    expectWhole(around);
    for (std::size_t i = 0; i < around.size(); ++i) EXPECT_LE(around.of(i).size(), 33U);
    ViewMetric metric(same, around);  // nothing differs
    Rows changed = same;
    metric.apply(changed);
    for (std::size_t i = 0; i < same.size(); ++i) ASSERT_FLOAT_EQ(changed[i], same[i]);
  }
}

TEST(ViewMetric, IsTheInverseRootOfTheCovariance) {
  const MetricDrive drive;
  const Neighborhoods around(drive.images, drive.poses, metricReach);
  Rows changed = drive.images;
  ViewMetric(drive.images, around).apply(changed);

  const auto images = static_cast<int>(around.size()), labels = static_cast<int>(metricLabels);
  cv::Mat_<double> residuals(images, labels);
  for (int i = 0; i < images; ++i) {
    const auto own = static_cast<std::size_t>(i);
    const Rows mean = around.mean(drive.images, own);
    for (int l = 0; l < labels; ++l)
      residuals(i, l) =
          rowOf(drive.images, own)[static_cast<std::size_t>(l)] - mean[static_cast<std::size_t>(l)];
  }
  const cv::Mat_<double> sigma = residuals.t() * residuals / images;
  cv::Mat_<double> values, vectors;
  cv::eigen(sigma, values, vectors);
  const double typical = cv::norm(values, cv::NORM_L2SQR) / cv::sum(values)[0];
  cv::Mat_<double> roots = cv::Mat_<double>::zeros(labels, labels);
  for (int l = 0; l < labels; ++l) roots(l, l) = 1 / std::sqrt(1 + values(l) / typical);
  const cv::Mat_<double> whitening = vectors.t() * roots * vectors;
  for (const std::size_t i : {0U, 17U, 71U}) {
    cv::Mat_<double> expected(labels, 1);
    for (int l = 0; l < labels; ++l) expected(l) = rowOf(drive.images, i)[static_cast<std::size_t>(l)];
    expected = whitening * expected;
    expected /= cv::norm(expected);
    // Directions of less than 1 % are left out.
    for (int l = 0; l < labels; ++l)
      EXPECT_NEAR(rowOf(changed, i)[static_cast<std::size_t>(l)], expected(l), 0.01) << i << " " << l;
  }
}

}  // namespace
}  // namespace estancia
