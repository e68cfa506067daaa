// SPDX-License-Identifier: Apache-2.0
#include "scenes/scene_answers.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/stats/proportion.hpp"

namespace estancia::experiments {
namespace {

constexpr const char* answerMeasure = "answer";

std::size_t at(const SceneTest& test, int truth, int answer) {
  return static_cast<std::size_t>(truth) * static_cast<std::size_t>(test.roomCount) +
         static_cast<std::size_t>(answer);
}

/// How many independent images would leave as much doubt.
double effectiveSize(const SceneTest& test, const std::vector<double>& right, double share) {
  const double runs = test.runCount, images = static_cast<double>(right.size());
  if (share <= 0 || share >= 1) return runs;
  if (test.runCount < 2) return 1;
  // The variance of a ratio: right answers over images, with the runs as what was drawn (Cochran 1977, 6.4).
  std::vector<double> excess(static_cast<std::size_t>(test.runCount));
  for (std::size_t i = 0; i < right.size(); ++i)
    excess[static_cast<std::size_t>(test.runs[i])] += right[i] - share;
  const double variance = runs / (runs - 1) *
                          std::inner_product(excess.begin(), excess.end(), excess.begin(), 0.0) /
                          (images * images);
  const double independent = variance > 0 ? std::min(share * (1 - share) / variance, images) : images;
  // Few runs give a poor estimate of their variance, hence Student's t.
  using namespace boost::math;
  const double doubt = quantile(normal(), 0.975) / quantile(students_t(runs - 1), 0.975);
  return std::max(independent * doubt * doubt, 1.0);
}

}  // namespace

Share shareRight(const SceneTest& test, const std::vector<double>& right) {
  if (right.empty())
    throw Error(ErrorCode::insufficientData,
                "no image was asked about, so that there is no share of right answers");
  const double share = std::accumulate(right.begin(), right.end(), 0.0) / static_cast<double>(right.size());
  const double n = effectiveSize(test, right, share);
  const auto [low, high] = wilsonInterval(share, n);
  return {share, low, high};
}

std::vector<double> SceneAnswers::right(const SceneTest& test) const {
  std::vector<double> shares(test.rooms.size());
  for (const auto& seed : answers)
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] += seed[i] == test.rooms[i] ? 1 : 0;
  for (double& share : shares) share /= static_cast<double>(answers.size());
  return shares;
}

std::vector<std::size_t> SceneAnswers::rightInRuns(const SceneTest& test) const {
  std::vector<std::size_t> counts(static_cast<std::size_t>(test.runCount));
  for (const auto& seed : answers)
    for (std::size_t i = 0; i < test.rooms.size(); ++i)
      if (seed[i] == test.rooms[i]) ++counts[static_cast<std::size_t>(test.runs[i])];
  return counts;
}

double SceneAnswers::accuracy(const SceneTest& test) const {
  const auto counts = rightInRuns(test);
  return static_cast<double>(std::accumulate(counts.begin(), counts.end(), std::size_t{0})) /
         static_cast<double>(answers.size() * test.rooms.size());
}

std::vector<double> SceneAnswers::confusion(const SceneTest& test) const {
  std::vector<double> counts(static_cast<std::size_t>(test.roomCount) *
                             static_cast<std::size_t>(test.roomCount));
  for (const auto& seed : answers)
    for (std::size_t i = 0; i < test.rooms.size(); ++i) counts[at(test, test.rooms[i], seed[i])] += 1;
  for (double& count : counts) count /= static_cast<double>(answers.size());
  return counts;
}

double SceneAnswers::balancedAccuracy(const SceneTest& test) const {
  const auto counts = confusion(test);
  double sum = 0, shown = 0;
  for (int room = 0; room < test.roomCount; ++room) {
    double images = 0;
    for (int answer = 0; answer < test.roomCount; ++answer) images += counts[at(test, room, answer)];
    if (images <= 0) continue;
    sum += counts[at(test, room, room)] / images;
    shown += 1;
  }
  return sum / shown;
}

CellResults SceneAnswers::toResults(const SceneTest& test) const {
  const Share accuracy = shareRight(test, right(test));
  CellResults results{{"accuracy", "", accuracy.value},
                      {"balanced_accuracy", "", balancedAccuracy(test)},
                      {"accuracy_low", "", accuracy.low},
                      {"accuracy_high", "", accuracy.high}};
  for (const auto& seed : answers)
    for (const int answer : seed) results.push_back({answerMeasure, "", static_cast<double>(answer)});
  return results;
}

SceneAnswers SceneAnswers::fromResults(const CellResults& results, const SceneTest& test, std::size_t seeds) {
  std::vector<int> all;
  for (const CellResult& result : results) {
    if (result.measure != answerMeasure) continue;
    if (!(result.value >= 0 && result.value < test.roomCount))
      throw Error(ErrorCode::corruptFile,
                  "a cell answers with a room that there is not; remove the folder `cells`");
    all.push_back(static_cast<int>(result.value));
  }
  const std::size_t images = test.rooms.size();
  if (all.size() != seeds * images)
    throw Error(ErrorCode::corruptFile,
                "a cell has not as many answers as there are images; remove the folder `cells`");
  SceneAnswers found;
  for (std::size_t s = 0; s < seeds; ++s)
    found.answers.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(s * images),
                               all.begin() + static_cast<std::ptrdiff_t>((s + 1) * images));
  return found;
}

}  // namespace estancia::experiments
