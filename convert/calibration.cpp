// SPDX-License-Identifier: Apache-2.0
#include "convert/calibration.hpp"

#include <fmt/format.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <set>

#include "convert/quantize.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/labelers/engines.hpp"
#include "estancia/labelers/network_labeler.hpp"

namespace estancia::convert {
namespace {

/// The network with these values as its only outputs.
std::string withOutputs(const std::string& onnx, const std::vector<std::string>& values) {
  onnx::ModelProto model;
  model.ParseFromString(onnx);
  std::set<std::string> computed;
  for (const auto& node : model.graph().node()) computed.insert(node.output().begin(), node.output().end());
  model.mutable_graph()->clear_output();
  for (const std::string& value : values) {
    if (!computed.contains(value)) continue;  // the image
    auto* output = model.mutable_graph()->add_output();
    output->set_name(value);
    output->mutable_type()->mutable_tensor_type()->set_elem_type(onnx::TensorProto::FLOAT);
  }
  return model.SerializeAsString();
}

/// The image as it is, and in less and more light.
std::vector<cv::Mat> inLights(const cv::Mat& image, double light) {
  std::vector<cv::Mat> lights{image};
  if (light == 0) return lights;
  for (const double change : {-light, light}) image.convertTo(lights.emplace_back(), -1, std::exp2(change));
  return lights;
}

}  // namespace

OptionGroup declare(CalibrationOptions& options) {
  OptionGroup group("calibration", "On which images the ranges of a network's values are measured.");
  group.add("images", &options.images, "Images, evenly spread over the sequence.")
      .range(1, 1'000'000)
      .why("A hundred do; more places and lights make the ranges surer.");
  group.add("light", &options.light, "Look at each image so much darker and brighter, too; 0: only as it is.")
      .range(0, 8)
      .unit("EV")
      .why("The robot will also drive by night; 0 when the images hold all lights.");
  return group;
}

void ValueHistogram::widen() {
  width_ *= 2;
  std::vector<std::uint64_t> wider(bins);
  for (int bin = 0; bin < bins; ++bin)
    wider[static_cast<std::size_t>(bins / 4 + bin / 2)] += counts_[static_cast<std::size_t>(bin)];
  counts_ = std::move(wider);
}

void ValueHistogram::add(std::span<const float> numbers) {
  float largest = 0;
  for (const float number : numbers)
    if (std::isfinite(number)) largest = std::max(largest, std::abs(number));
  while (largest >= bins / 2 * width_) widen();
  const auto perWidth = static_cast<float>(1 / width_);  // exact: a power of two
  for (const float number : numbers) {
    if (number == 0 || !std::isfinite(number)) {
      ++zeros_;
      continue;
    }
    const int bin = bins / 2 + static_cast<int>(std::floor(number * perWidth));
    ++counts_[static_cast<std::size_t>(bin)];
  }
}

double ValueHistogram::squaredError(double low, double high) const {
  const double step = (high - low) / 255;
  const double zero = std::nearbyint(-low / step);
  double error = 0;
  for (int bin = 0; bin < bins; ++bin) {
    const std::uint64_t count = counts_[static_cast<std::size_t>(bin)];
    if (count == 0) continue;
    const double number = centerOf(bin);
    const double stored = std::clamp(std::nearbyint(number / step) + zero, 0.0, 255.0);
    const double difference = (stored - zero) * step - number;
    error += static_cast<double>(count) * difference * difference;
  }
  return error;
}

ActivationRange ValueHistogram::range() const {
  const auto isFilled = [](std::uint64_t count) { return count > 0; };
  const auto first = std::find_if(counts_.begin(), counts_.end(), isFilled);
  if (first == counts_.end()) return {};
  const auto last = std::find_if(counts_.rbegin(), counts_.rend(), isFilled);
  const double lowest = std::min(0.0, (first - counts_.begin() - bins / 2) * width_);
  const double highest = std::max(0.0, (counts_.rend() - last - bins / 2) * width_);
  double share = 1, least = squaredError(lowest, highest);
  constexpr int candidates = 50;
  for (int k = 1; k < candidates - 2; ++k) {
    const double less = 1 - static_cast<double>(k) / candidates;
    const double error = squaredError(lowest * less, highest * less);
    if (error >= least) continue;
    least = error;
    share = less;
  }
  return {static_cast<float>(lowest * share), static_cast<float>(highest * share)};
}

namespace {

/// A network whose values are counted.
class Measurement {
 public:
  Measurement(const ModelSpec& spec, const std::string& onnx, int threads)
      : spec_(spec),
        source_((spec.folder / spec.file).string()),
        values_(valuesToQuantize(onnx, source_)),
        network_(openNetworkValues(withOutputs(onnx, values_), source_, threads)),
        computed_(network_->names().size()) {}

  void look(const cv::Mat& image) {
    const cv::Mat blob = preprocess(image, spec_.preprocessing);
    input_.add({blob.ptr<float>(), blob.total()});
    network_->run(blob,
                  [&](std::size_t value, std::span<const float> numbers) { computed_[value].add(numbers); });
  }

  ActivationRanges ranges() const {
    ActivationRanges ranges;
    for (std::size_t v = 0; v < computed_.size(); ++v) ranges[network_->names()[v]] = computed_[v].range();
    for (const std::string& value : values_)
      if (!ranges.contains(value)) ranges[value] = input_.range();
    return ranges;
  }

 private:
  const ModelSpec& spec_;
  const std::string source_;
  const std::vector<std::string> values_;
  const std::unique_ptr<NetworkValues> network_;
  std::vector<ValueHistogram> computed_;
  ValueHistogram input_;
};

}  // namespace

MeasuredRanges measureRanges(const ModelSpec& spec, const std::string& onnx, const Sequence& images,
                             const CalibrationOptions& options, int threads, Progress& progress) {
  validate(options);
  Measurement measurement(spec, onnx, threads);
  MeasuredRanges measured;
  const std::size_t count = std::min(options.images, images.size());
  progress.begin("measuring the network", count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t frame = i * images.size() / count;
    try {
      for (const cv::Mat& image : inLights(images.image(frame), options.light)) measurement.look(image);
      ++measured.images;
    } catch (...) {
      const Error failure = frameFailure(images.frame(frame).name);
      if (i + 1 == count && measured.images == 0) throw failure;
      measured.problems.emplace_back(failure.what());
    }
    progress.advance();
    if (interrupted())
      throw Interrupted(fmt::format("stopped after {} of {} images; nothing was written", i + 1, count));
  }
  progress.end();
  if (measured.images == 0)
    throw Error(ErrorCode::insufficientData, fmt::format("{} holds no images", images.name()));
  measured.ranges = measurement.ranges();
  return measured;
}

}  // namespace estancia::convert
