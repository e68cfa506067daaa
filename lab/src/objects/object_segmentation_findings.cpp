// SPDX-License-Identifier: Apache-2.0
#include "objects/object_segmentation_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "estancia/files/image_writer.hpp"
#include "estancia/stats/proportion.hpp"
#include "findings/pivot.hpp"

namespace estancia::experiments {
namespace {

SegmentationScore operator+(const SegmentationScore& a, const SegmentationScore& b) {
  return {a.objects + b.objects, a.found + b.found, a.over + b.over, a.under + b.under, a.iou + b.iou};
}

PrecisionRecall operator+(const PrecisionRecall& a, const PrecisionRecall& b) {
  return {a.precision + b.precision, a.recall + b.recall, a.f + b.f};
}

SegmentationMeasures operator+(const SegmentationMeasures& a, const SegmentationMeasures& b) {
  return {a.overlap + b.overlap, a.boundary + b.boundary, a.atThreeQuarters + b.atThreeQuarters};
}

using Rows = std::vector<std::pair<std::string, SegmentedScene>>;

SegmentedScene operator+(const SegmentedScene& a, const SegmentedScene& b) {
  return {"",
          "",
          a.ours + b.ours,
          a.euclidean + b.euclidean,
          a.measures + b.measures,
          a.euclideanMeasures + b.euclideanMeasures,
          a.scenes + b.scenes,
          a.postersTold + b.postersTold,
          a.takenForFlat + b.takenForFlat};
}

/// Sums of the categories in the order that they come, then of all scenes.
Rows byCategory(const std::vector<SegmentedScene>& scenes) {
  Rows sums;
  SegmentedScene all, none;
  all.scenes = none.scenes = 0;
  for (const SegmentedScene& scene : scenes) {
    if (scene.ours.objects == 0) continue;
    all = all + scene;
    if (scene.category.empty()) continue;
    auto sum = std::find_if(sums.begin(), sums.end(),
                            [&](const auto& known) { return known.first == scene.category; });
    if (sum == sums.end()) sum = sums.insert(sum, {scene.category, none});
    sum->second = sum->second + scene;
  }
  sums.emplace_back("all", all);
  return sums;
}

double percent(std::size_t part, std::size_t whole) {
  return 100 * static_cast<double>(part) / static_cast<double>(whole);
}

double number(std::size_t n) {
  return static_cast<double>(n);
}

ResultTable scores(const Rows& sums, const std::string& title, const std::string& caption,
                   SegmentationScore SegmentedScene::*score) {
  const auto count = [score](std::size_t SegmentationScore::*which) {
    return [=](const SegmentedScene& sum) { return number(sum.*score.*which); };
  };
  const auto interval = [score](const SegmentedScene& sum) {
    return wilsonInterval((sum.*score).found, (sum.*score).objects);
  };
  return pivot<SegmentedScene>(
      {title, caption, "category", {}, {}}, sums,
      {{{"objects", 0}, count(&SegmentationScore::objects)},
       {{"found", 0}, count(&SegmentationScore::found)},
       {{"found [%]", 1}, [=](auto& sum) { return percent((sum.*score).found, (sum.*score).objects); }},
       {{"from [%]", 1}, [=](auto& sum) { return 100 * interval(sum).first; }},
       {{"to [%]", 1}, [=](auto& sum) { return 100 * interval(sum).second; }},
       {{"over-segmented", 0}, count(&SegmentationScore::over)},
       {{"under-segmented", 0}, count(&SegmentationScore::under)},
       {{"mean IoU", 3}, [=](auto& sum) { return (sum.*score).iou / number((sum.*score).objects); }}});
}

ResultTable measures(const Rows& sums, const std::string& title, const std::string& caption,
                     SegmentationMeasures SegmentedScene::*which) {
  const auto mean = [which](PrecisionRecall SegmentationMeasures::*kind, double PrecisionRecall::*what) {
    return [=](const SegmentedScene& sum) { return 100 * (sum.*which.*kind.*what) / number(sum.scenes); };
  };
  constexpr auto overlap = &SegmentationMeasures::overlap, boundary = &SegmentationMeasures::boundary;
  return pivot<SegmentedScene>({title, caption, "category", {}, {}}, sums,
                               {{{"overlap P [%]", 1}, mean(overlap, &PrecisionRecall::precision)},
                                {{"R [%]", 1}, mean(overlap, &PrecisionRecall::recall)},
                                {{"F [%]", 1}, mean(overlap, &PrecisionRecall::f)},
                                {{"boundary P [%]", 1}, mean(boundary, &PrecisionRecall::precision)},
                                {{"boundary R [%]", 1}, mean(boundary, &PrecisionRecall::recall)},
                                {{"boundary F [%]", 1}, mean(boundary, &PrecisionRecall::f)},
                                {{"F above .75 [%]", 1}, [which](const SegmentedScene& sum) {
                                   return 100 * (sum.*which).atThreeQuarters / number(sum.ours.objects);
                                 }}});
}

/// A color for the i-th object, unlike those of its neighbors.
cv::Vec3b colorOf(std::size_t i) {
  const cv::Mat hsv(1, 1, CV_8UC3, cv::Scalar(static_cast<double>(i * 67 % 180), 190, 235));
  cv::Mat bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr.at<cv::Vec3b>(0, 0);
}

cv::Mat painted(const cv::Mat& bgr, const std::vector<PixelSet>& objects) {
  cv::Mat gray, image;
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::cvtColor(gray, image, cv::COLOR_GRAY2BGR);
  for (std::size_t t = 0; t < objects.size(); ++t)
    for (const std::uint32_t pixel : objects[t]) {
      cv::Vec3b& to = image.ptr<cv::Vec3b>()[pixel];
      for (int channel = 0; channel < 3; ++channel)
        to[channel] = static_cast<unsigned char>((to[channel] + 2 * colorOf(t)[channel]) / 3);
    }
  return image;
}

}  // namespace

Findings findingsOf(const std::vector<SegmentedScene>& scenes) {
  Findings findings;
  findings.title = "Object segmentation";
  const auto sums = byCategory(scenes);
  const SegmentedScene& all = sums.back().second;
  findings.summary = fmt::format(
      "{} of {} objects are found ({:.1f} %; Euclidean clusters: {:.1f} %), {} are over-segmented, {} "
      "under-segmented; of {} photographs {} are found to be flat, and of as many objects {}.",
      all.ours.found, all.ours.objects, percent(all.ours.found, all.ours.objects),
      percent(all.euclidean.found, all.euclidean.objects), all.ours.over, all.ours.under, all.ours.objects,
      all.postersTold, all.takenForFlat);
  findings.sections.emplace_back(scores(
      sums, "Objects found",
      "Found: the best cluster's intersection over union with the object, over pixels with depth, is 0.5 or "
      "more; from … to: 95 % interval of that share (Wilson). Over-segmented: two clusters or more hold a "
      "fifth "
      "of the object each. Under-segmented: a cluster that holds a fifth of it holds a fifth of another one.",
      &SegmentedScene::ours));
  findings.sections.emplace_back(scores(sums, "The thesis' way: Euclidean clusters",
                                        "Of what is left without the same planes.",
                                        &SegmentedScene::euclidean));
  findings.sections.emplace_back(measures(
      sums, "Overlap and boundary",
      "As published for learned segmentation: clusters and objects are assigned one to one for the greatest "
      "sum of F; precision P, recall R and F of their pixels, and of the pixels of their boundaries within "
      "0.3 % of the image's diagonal, means over the scenes; share of the objects whose F is above .75.",
      &SegmentedScene::measures));
  findings.sections.emplace_back(measures(sums, "Overlap and boundary of Euclidean clusters", "The same.",
                                          &SegmentedScene::euclideanMeasures));
  findings.sections.emplace_back(pivot<SegmentedScene>(
      {"Photographs of the objects (the question of Table 6.1)",
       "A photograph: the object's pixels on a plane that faces the camera, with a Kinect's "
       "noise. A box of which one face alone is seen is truly flat.",
       "category",
       {},
       {}},
      sums,
      {{{"photographs", 0}, [](auto& sum) { return number(sum.ours.objects); }},
       {{"found to be flat", 0}, [](auto& sum) { return number(sum.postersTold); }},
       {{"objects taken for flat", 0}, [](auto& sum) { return number(sum.takenForFlat); }}}));
  return findings;
}

std::vector<std::size_t> bestFirst(const std::vector<SegmentedScene>& scenes) {
  return ascending(scenes.size(), [&](std::size_t i) {
    const SegmentationScore& s = scenes[i].ours;
    return s.objects == 0 ? 0.0 : -s.iou / number(s.objects);
  });
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
