// SPDX-License-Identifier: Apache-2.0
#include "features/visual_vocabulary.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>
#include <span>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/fail.hpp"
#include "places/kmeans.hpp"

namespace estancia::experiments {
namespace {

// iterations of k-means; the words of an image hardly change after a dozen
constexpr std::size_t iterations = 20;

std::span<const float> rowOf(const cv::Mat& matrix, std::size_t row) {
  return {matrix.ptr<float>(static_cast<int>(row)), static_cast<std::size_t>(matrix.cols)};
}

/// Every so many features of each image: about `wanted` of all.
DescriptorMatrix sampleOf(const std::vector<cv::Mat>& images, std::size_t wanted) {
  std::size_t all = 0, length = 0;
  for (const cv::Mat& features : images) {
    if (features.rows == 0) continue;
    const auto own = static_cast<std::size_t>(features.cols);
    if (length != 0 && own != length)
      fail(ErrorCode::mismatch, "local features have {} and {} values; give those of one kind", length, own);
    length = own;
    all += static_cast<std::size_t>(features.rows);
  }
  DescriptorMatrix sample(length);
  const std::size_t stride = std::max<std::size_t>(1, all / std::max<std::size_t>(1, wanted));
  std::size_t next = 0, first = 0;  // numbers of features, over all images
  for (const cv::Mat& features : images) {
    const auto end = first + static_cast<std::size_t>(features.rows);
    for (; next < end; next += stride) sample.append(rowOf(features, next - first));
    first = end;
  }
  return sample;
}

cv::Mat meansOf(const DescriptorMatrix& rows, const std::vector<int>& clusters, std::size_t count) {
  std::vector<double> sums(count * rows.labels()), sizes(count);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto cluster = static_cast<std::size_t>(clusters[i]);
    ++sizes[cluster];
    for (std::size_t c = 0; c < rows.labels(); ++c) sums[cluster * rows.labels() + c] += rows.row(i)[c];
  }
  cv::Mat means(static_cast<int>(count), static_cast<int>(rows.labels()), CV_32F);
  for (std::size_t i = 0; i < sums.size(); ++i)
    means.ptr<float>()[i] = static_cast<float>(sums[i] / sizes[i / rows.labels()]);
  return means;
}

}  // namespace

VisualVocabulary learnVisualVocabulary(const std::vector<cv::Mat>& images,
                                       const VisualVocabularyOptions& options) {
  const DescriptorMatrix sample = sampleOf(images, options.sampled);
  if (options.words == 0 || sample.size() < options.words)
    fail(ErrorCode::insufficientData,
         "{} local features cannot make {} visual words; give more images, or ask for 1 to {} words",
         sample.size(), options.words, sample.size());
  const auto clusters = kMeans(sample, options.words, {1, options.seed, iterations});
  VisualVocabulary vocabulary{meansOf(sample, clusters, options.words), {}};
  std::vector<std::size_t> with(options.words);
  std::size_t documents = 0;
  for (const cv::Mat& features : images) {
    if (features.rows == 0) continue;
    ++documents;
    const auto words = wordsOf(vocabulary, features);
    for (const std::size_t word : std::set(words.begin(), words.end())) ++with[word];
  }
  for (const std::size_t count : with)
    vocabulary.idf.push_back(static_cast<float>(
        std::log(static_cast<double>(documents) / static_cast<double>(std::max<std::size_t>(1, count)))));
  return vocabulary;
}

std::vector<std::size_t> wordsOf(const VisualVocabulary& vocabulary, const cv::Mat& features) {
  if (features.rows == 0) return {};
  if (features.cols != vocabulary.words.cols || features.type() != CV_32F)
    fail(ErrorCode::mismatch, "local features have {} values where the visual words have {}; take one kind",
         features.cols, vocabulary.words.cols);
  // |f − w|² = |f|² − 2 (f·w − |w|²/2): the nearest word has the largest bracket.
  const cv::Mat products = features * vocabulary.words.t();
  std::vector<float> halves;
  for (int w = 0; w < vocabulary.words.rows; ++w)
    halves.push_back(static_cast<float>(vocabulary.words.row(w).dot(vocabulary.words.row(w)) / 2));
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < static_cast<std::size_t>(features.rows); ++i) {
    const auto row = rowOf(products, i);
    std::size_t best = 0;
    for (std::size_t w = 1; w < row.size(); ++w)
      if (row[w] - halves[w] > row[best] - halves[best]) best = w;
    nearest.push_back(best);
  }
  return nearest;
}

std::vector<float> bagOfWords(const VisualVocabulary& vocabulary, const cv::Mat& features) {
  const std::size_t words = vocabulary.idf.size();
  std::vector<float> bag(words);
  for (const std::size_t word : wordsOf(vocabulary, features)) bag[word] += vocabulary.idf[word];
  const double sum = std::accumulate(bag.begin(), bag.end(), 0.0);
  if (sum <= 0) return std::vector<float>(words, 1.0F / static_cast<float>(words));
  for (float& share : bag) share = static_cast<float>(share / sum);
  return bag;
}

std::vector<float> vlad(const VisualVocabulary& vocabulary, const cv::Mat& features) {
  const auto length = static_cast<std::size_t>(vocabulary.words.cols);
  std::vector<float> sums(vocabulary.words.total());
  const auto words = wordsOf(vocabulary, features);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto feature = rowOf(features, i), word = rowOf(vocabulary.words, words[i]);
    for (std::size_t c = 0; c < length; ++c) sums[words[i] * length + c] += feature[c] - word[c];
  }
  double squares = 0;
  for (float& value : sums) {
    squares += std::abs(value);  // the sum of absolute values is the squared norm of the root
    value = std::copysign(std::sqrt(std::abs(value)), value);
  }
  if (squares > 0)
    for (float& value : sums) value = static_cast<float>(value / std::sqrt(squares));
  return sums;
}

}  // namespace estancia::experiments
