// SPDX-License-Identifier: Apache-2.0
#include "estancia/findings/label_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "estancia/core/fail.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/printable.hpp"

namespace estancia {
namespace {

/// How often the images have one label.
struct LabelCount {
  std::size_t label = 0;
  /// Images that have it.
  std::size_t images = 0;
  /// Mean probability over all images.
  double mean = 0;
};

/// The most frequent first; of equal ones the more probable.
std::vector<LabelCount> countLabels(const DescriptorSequence& sequence, std::size_t labelsPerImage) {
  const std::size_t images = sequence.frames.size();
  std::vector<LabelCount> counts(sequence.vocabulary.size());
  for (std::size_t l = 0; l < counts.size(); ++l) counts[l].label = l;
  for (std::size_t i = 0; i < images; ++i) {
    const DescriptorView row = sequence.descriptors.row(i);
    for (std::size_t l = 0; l < counts.size(); ++l) counts[l].mean += row[l] / static_cast<double>(images);
    for (const std::size_t l : bestLabels(row, labelsPerImage))
      if (row[l] > 0) ++counts[l].images;
  }
  std::erase_if(counts, [](const LabelCount& count) { return count.images == 0; });
  std::ranges::sort(counts, [](const LabelCount& a, const LabelCount& b) {
    return a.images != b.images ? a.images > b.images
           : a.mean != b.mean   ? a.mean > b.mean
                                : a.label < b.label;
  });
  return counts;
}

/// Images by the probability of a label.
std::vector<std::size_t> bestImagesOf(const DescriptorSequence& sequence, std::size_t label,
                                      std::size_t most) {
  std::vector<std::size_t> images(sequence.frames.size());
  std::iota(images.begin(), images.end(), std::size_t{0});
  const auto count = std::min(most, images.size());
  std::ranges::partial_sort(
      images, images.begin() + static_cast<std::ptrdiff_t>(count), [&](std::size_t a, std::size_t b) {
        const float pa = sequence.descriptors.row(a)[label], pb = sequence.descriptors.row(b)[label];
        return pa != pb ? pa > pb : a < b;
      });
  images.resize(count);
  return images;
}

/// The share of all that the most frequent labels have, by their number (Fig. 3.12).
LineChart curveOf(const std::vector<LabelCount>& counts, std::size_t all, std::size_t half) {
  LineChart chart{"How few labels say how much",
                  "The share of all labels of all images that the most frequent ones are. The dot is where "
                  "they are half of all.",
                  "number of labels",
                  "share",
                  false,
                  {},
                  {{"labels", {}, static_cast<double>(half)}}};
  double sum = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    sum += static_cast<double>(counts[k].images) / static_cast<double>(all);
    chart.x.push_back(static_cast<double>(k + 1));
    chart.lines[0].y.push_back(sum);
  }
  return chart;
}

}  // namespace

Findings labelFindings(const DescriptorSequence& sequence, const ImageOfFrame& image,
                       const LabelFindingsOptions& options) {
  std::vector<LabelCount> counts = countLabels(sequence, options.labelsPerImage);
  if (counts.empty()) fail(ErrorCode::insufficientData, "no image has a label; label some images first");
  const std::size_t images = sequence.frames.size();
  std::size_t all = 0, half = 0, soFar = 0;
  for (const LabelCount& count : counts) all += count.images;
  for (; 2 * soFar < all; ++half) soFar += counts[half].images;
  const auto name = [&](const LabelCount& count) { return shortLabel(sequence.vocabulary[count.label]); };

  Findings findings;
  findings.title = fmt::format("Labels of {} images", images);
  findings.summary = fmt::format("{} of {} labels occur; the {} most frequent are half of all.",
                                 counts.size(), sequence.vocabulary.size(), half);
  findings.facts = {{"Model", sequence.model},
                    {"Images", fmt::format("{}", images)},
                    {"Labels of an image", fmt::format("its {} most probable", options.labelsPerImage)}};

  WordClouds clouds{"Labels", "The more images have a label, the larger it is.", {{"all images", {}}}};
  for (std::size_t k = 0; k < std::min(counts.size(), 10 * options.tableRows); ++k)
    clouds.clouds[0].words.emplace_back(name(counts[k]), static_cast<double>(counts[k].images));
  findings.sections.emplace_back(std::move(clouds));
  findings.sections.emplace_back(curveOf(counts, all, half));

  ResultTable table;
  table.title = "The most frequent labels";
  table.caption = "Images that have the label, and its mean probability over all images.";
  table.rowsAre = "label";
  table.columns = {{"images", 0}, {"share of images [%]", 1}, {"mean probability", 4}};
  for (std::size_t k = 0; k < std::min(counts.size(), options.tableRows); ++k)
    table.rows.push_back(
        {name(counts[k]),
         {static_cast<double>(counts[k].images),
          100.0 * static_cast<double>(counts[k].images) / static_cast<double>(images), counts[k].mean}});
  findings.sections.emplace_back(std::move(table));

  Images shown{"Images that show a label best", "By its probability.", {}};
  for (std::size_t k = 0; image && k < std::min(counts.size(), options.imageLabels); ++k)
    for (const std::size_t i : bestImagesOf(sequence, counts[k].label, options.imagesPerLabel))
      if (std::vector<unsigned char> file = image(i); !file.empty())
        shown.images.push_back({std::move(file), fmt::format("{} {:.2f}, {}", name(counts[k]),
                                                             sequence.descriptors.row(i)[counts[k].label],
                                                             printable(sequence.frames[i].name))});
  if (!shown.images.empty()) findings.sections.emplace_back(std::move(shown));
  return findings;
}

}  // namespace estancia
