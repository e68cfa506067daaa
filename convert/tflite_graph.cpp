// SPDX-License-Identifier: Apache-2.0
#include "convert/tflite_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "estancia/core/error.hpp"

namespace estancia::tflite {
namespace {

template <class Stored>
Stored loadElement(const Tensor& tensor, std::size_t i) {
  Stored value;
  std::memcpy(&value, tensor.bytes.data() + i * sizeof(Stored), sizeof(Stored));
  return value;
}

/// Calls use(i, value) for each stored element.
template <class Stored, class Use>
void forEachElement(const Tensor& tensor, Use use) {
  const std::size_t count = tensor.bytes.size() / sizeof(Stored);
  for (std::size_t i = 0; i < count; ++i) use(i, loadElement<Stored>(tensor, i));
}

}  // namespace

std::size_t Tensor::elements() const {
  std::size_t count = 1;
  for (const int size : shape) count *= static_cast<std::size_t>(size);
  return count;
}

float Tensor::lowest() const {
  if (scale.size() != 1 || (type != ElementType::uint8 && type != ElementType::int8))
    return -std::numeric_limits<float>::infinity();
  return scale[0] * static_cast<float>((type == ElementType::uint8 ? 0 : -128) - zeroPoint[0]);
}

float Tensor::highest() const {
  if (scale.size() != 1 || (type != ElementType::uint8 && type != ElementType::int8))
    return std::numeric_limits<float>::infinity();
  return scale[0] * static_cast<float>((type == ElementType::uint8 ? 255 : 127) - zeroPoint[0]);
}

Window placeWindow(std::int64_t size, int filter, int stride, int dilation, bool samePadding) {
  const std::int64_t span = std::int64_t{filter - 1} * dilation + 1;
  if (!samePadding) return {0, 0, size < span ? 0 : (size - span) / stride + 1};
  const std::int64_t outputs = (size + stride - 1) / stride;
  const std::int64_t padding = std::max<std::int64_t>(0, (outputs - 1) * stride + span - size);
  return {padding / 2, padding - padding / 2, outputs};
}

float halfToFloat(std::uint16_t bits) {
  const unsigned sign = (bits & 0x8000U) << 16U, exponent = bits >> 10U & 31U, fraction = bits & 1023U;
  if (exponent == 0)
    return std::copysign(std::ldexp(static_cast<float>(fraction), -24), sign == 0 ? 1.0F : -1.0F);
  const unsigned wide = exponent == 31 ? 255 : exponent + 127 - 15;
  return std::bit_cast<float>(sign | wide << 23U | fraction << 13U);
}

std::vector<float> realValues(const Tensor& tensor, const std::string& source) {
  if (!tensor.constant)
    throw Error(ErrorCode::malformedFile,
                fmt::format("{} computes {}, which must be stored", source, tensor.name));
  if (tensor.type == ElementType::float32) {
    std::vector<float> values(tensor.elements());
    std::memcpy(values.data(), tensor.bytes.data(), tensor.bytes.size());
    return values;
  }
  if (tensor.type != ElementType::float16 && tensor.scale.empty())
    throw Error(ErrorCode::malformedFile,
                fmt::format("{} stores {} as integers without a scale", source, tensor.name));

  std::size_t inner = 1;  // elements that share one index of the axis
  for (std::size_t d = static_cast<std::size_t>(tensor.axis) + 1; d < tensor.shape.size(); ++d)
    inner *= static_cast<std::size_t>(tensor.shape[d]);
  std::vector<float> values(tensor.elements());
  const auto dequantize = [&](std::size_t i, auto stored) {
    const std::size_t channel = tensor.scale.size() == 1 ? 0 : i / inner % tensor.scale.size();
    const double difference = static_cast<double>(stored) - static_cast<double>(tensor.zeroPoint[channel]);
    values[i] = static_cast<float>(tensor.scale[channel] * difference);
  };
  switch (tensor.type) {
    case ElementType::uint8:
      forEachElement<std::uint8_t>(tensor, dequantize);
      break;
    case ElementType::int8:
      forEachElement<std::int8_t>(tensor, dequantize);
      break;
    case ElementType::int32:
      forEachElement<std::int32_t>(tensor, dequantize);
      break;
    case ElementType::int64:
      forEachElement<std::int64_t>(tensor, dequantize);
      break;
    case ElementType::float16:
      forEachElement<std::uint16_t>(
          tensor, [&](std::size_t i, std::uint16_t bits) { values[i] = halfToFloat(bits); });
      break;
    case ElementType::float32:
    case ElementType::other:
      throw Error(ErrorCode::unsupportedFile,
                  fmt::format("{} stores {} in an unsupported type", source, tensor.name));
  }
  return values;
}

std::vector<std::int64_t> integerValues(const Tensor& tensor, const std::string& source) {
  std::vector<std::int64_t> values(tensor.constant ? tensor.elements() : 0);
  const auto copy = [&](std::size_t i, auto stored) { values[i] = stored; };
  if (tensor.constant && tensor.type == ElementType::int32)
    forEachElement<std::int32_t>(tensor, copy);
  else if (tensor.constant && tensor.type == ElementType::int64)
    forEachElement<std::int64_t>(tensor, copy);
  else
    throw Error(ErrorCode::malformedFile,
                fmt::format("{} has no stored integers in {}", source, tensor.name));
  return values;
}

}  // namespace estancia::tflite
