// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/cdr_writer.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t cdrHeader = 4;

std::vector<std::byte> headerOfCdr() {
  return {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
}

}  // namespace

CdrWriter::CdrWriter() : bytes_(headerOfCdr()) {}

void CdrWriter::put(std::string_view text) {
  putCount(text.size() + 1);
  append(text.data(), text.size());
  bytes_.push_back(std::byte{0});
}

void CdrWriter::putCount(std::size_t count) {
  if (count > std::numeric_limits<std::uint32_t>::max())
    fail(ErrorCode::tooLarge, "a message of ROS cannot hold {} elements in a row; publish fewer", count);
  put(static_cast<std::uint32_t>(count));
}

void CdrWriter::putBytes(std::span<const std::byte> bytes) {
  putCount(bytes.size());
  append(bytes.data(), bytes.size());
}

void CdrWriter::putTime(std::int64_t nanoseconds) {
  constexpr std::int64_t second = 1'000'000'000;
  using Seconds = std::numeric_limits<std::int32_t>;
  const std::int64_t time =
      std::clamp(nanoseconds, Seconds::min() * second, Seconds::max() * second + second - 1);
  const std::int64_t rest = (time % second + second) % second;
  put(static_cast<std::int32_t>((time - rest) / second));
  put(static_cast<std::uint32_t>(rest));
}

std::vector<std::byte> CdrWriter::take() {
  return std::exchange(bytes_, headerOfCdr());
}

void CdrWriter::align(std::size_t size) {
  const std::size_t beyond = (bytes_.size() - cdrHeader) % size;
  if (beyond > 0) bytes_.resize(bytes_.size() + size - beyond);
}

void CdrWriter::append(const void* data, std::size_t size) {
  const auto* from = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), from, from + size);
}

}  // namespace estancia::ros
