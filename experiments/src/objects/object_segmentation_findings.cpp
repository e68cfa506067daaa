#include "experiments/src/objects/object_segmentation_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "estancia/io/image_writer.hpp"
#include "estancia/stats/proportion.hpp"

namespace estancia::experiments {
namespace {

using Best = ResultTable::Best;

SegmentationScore operator+(const SegmentationScore& a, const SegmentationScore& b) {
  return {a.objects + b.objects, a.found + b.found, a.over + b.over, a.under + b.under, a.iou + b.iou};
}

/// Categories in the order that they come, and, as "", all together.
std::vector<SegmentedScene> byCategory(const std::vector<SegmentedScene>& scenes) {
  std::vector<SegmentedScene> sums;
  const auto add = [&sums](const std::string& category, const SegmentedScene& scene) {
    auto sum = std::find_if(sums.begin(), sums.end(),
                            [&](const SegmentedScene& known) { return known.category == category; });
    if (sum == sums.end()) sum = sums.insert(sum, {"", category, {}, {}});
    sum->ours = sum->ours + scene.ours;
    sum->euclidean = sum->euclidean + scene.euclidean;
    sum->postersTold += scene.postersTold;
    sum->takenForFlat += scene.takenForFlat;
  };
  for (const SegmentedScene& scene : scenes)
    if (!scene.category.empty()) add(scene.category, scene);
  std::erase_if(sums, [](const SegmentedScene& sum) { return sum.ours.objects == 0; });
  for (const SegmentedScene& scene : scenes) add("", scene);
  return sums;
}

std::string nameOf(const SegmentedScene& sum) {
  return sum.category.empty() ? "all" : sum.category;
}

double percent(std::size_t part, std::size_t whole) {
  return 100 * static_cast<double>(part) / static_cast<double>(whole);
}

ResultTable scores(const std::vector<SegmentedScene>& sums, const std::string& title,
                   const std::string& caption, SegmentationScore SegmentedScene::*score) {
  ResultTable table{title,
                    caption,
                    "category",
                    {{"objects", 0},
                     {"found", 0},
                     {"found [%]", 1},
                     {"from [%]", 1},
                     {"to [%]", 1},
                     {"cut apart", 0},
                     {"run together", 0},
                     {"mean IoU", 3}},
                    {}};
  for (const SegmentedScene& sum : sums) {
    const SegmentationScore& s = sum.*score;
    const auto [low, high] = wilsonInterval(s.found, s.objects);
    const auto number = [](std::size_t n) { return static_cast<double>(n); };
    table.rows.push_back({nameOf(sum),
                          {number(s.objects), number(s.found), percent(s.found, s.objects), 100 * low,
                           100 * high, number(s.over), number(s.under), s.iou / number(s.objects)}});
  }
  return table;
}

/// A color for the i-th thing, unlike those of its neighbors.
cv::Vec3b colorOf(std::size_t i) {
  const cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar(static_cast<double>(i * 67 % 180), 190, 235));
  cv::Mat bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr.at<cv::Vec3b>(0, 0);
}

cv::Mat painted(const cv::Mat& bgr, const std::vector<PixelSet>& things) {
  cv::Mat gray, image;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::cvtColor(gray, image, cv::COLOR_GRAY2BGR);
  for (std::size_t t = 0; t < things.size(); ++t)
    for (const std::uint32_t pixel : things[t]) {
      cv::Vec3b& to = image.ptr<cv::Vec3b>()[pixel];
      for (int channel = 0; channel < 3; ++channel)
        to[channel] = static_cast<unsigned char>((to[channel] + 2 * colorOf(t)[channel]) / 3);
    }
  return image;
}

}  // namespace

Findings findingsOf(const std::vector<SegmentedScene>& scenes) {
  Findings findings;
  findings.title = "Are the things found?";
  const auto sums = byCategory(scenes);
  const SegmentedScene& all = sums.back();
  findings.summary = fmt::format(
      "{} of {} objects are found ({:.1f} %; Euclidean clusters: {:.1f} %), {} are cut apart, {} run "
      "together; of {} photographs {} are told to be flat, and of as many objects {}.",
      all.ours.found, all.ours.objects, percent(all.ours.found, all.ours.objects),
      percent(all.euclidean.found, all.euclidean.objects), all.ours.over, all.ours.under, all.ours.objects,
      all.postersTold, all.takenForFlat);
  findings.sections.emplace_back(scores(
      sums, "Objects found",
      "Found: the best cluster's intersection over union with the object, over pixels with depth, is 0.5 or "
      "more; from … to: 95 % interval of that share (Wilson). Cut apart: two clusters or more hold a fifth "
      "of "
      "the object each. Run together: a cluster that holds a fifth of it holds a fifth of another one.",
      &SegmentedScene::ours));
  findings.sections.emplace_back(scores(sums, "The thesis' way: Euclidean clusters",
                                        "Of what is left without the same planes.",
                                        &SegmentedScene::euclidean));
  ResultTable posters{"Photographs of the objects (the question of Table 6.1)",
                      "A photograph: the object's pixels on a plane that faces the camera, with a Kinect's "
                      "noise. A box of which one face alone is seen is truly flat.",
                      "category",
                      {{"photographs", 0}, {"told to be flat", 0}, {"objects taken for flat", 0}},
                      {}};
  for (const SegmentedScene& sum : sums)
    posters.rows.push_back({nameOf(sum),
                            {static_cast<double>(sum.ours.objects), static_cast<double>(sum.postersTold),
                             static_cast<double>(sum.takenForFlat)}});
  findings.sections.emplace_back(std::move(posters));
  return findings;
}

std::vector<std::size_t> bestFirst(const std::vector<SegmentedScene>& scenes) {
  const auto goodness = [&](std::size_t i) {
    const SegmentationScore& s = scenes[i].ours;
    return s.objects == 0 ? 0.0 : s.iou / static_cast<double>(s.objects);
  };
  std::vector<std::size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return goodness(a) > goodness(b); });
  return order;
}

std::vector<unsigned char> segmentationImage(const cv::Mat& bgr, const cv::Mat& truth,
                                             const std::vector<PixelSet>& clusters) {
  constexpr int width = 900;
  cv::Mat image = bgr, row;
  if (image.size() != truth.size()) cv::resize(bgr, image, truth.size(), 0, 0, cv::INTER_AREA);
  cv::hconcat(std::vector<cv::Mat>{image, painted(image, objectsOf(truth)), painted(image, clusters)}, row);
  return encodeImage(row, width);
}

}  // namespace estancia::experiments
