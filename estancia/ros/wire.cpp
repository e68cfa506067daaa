// SPDX-License-Identifier: Apache-2.0
#include "estancia/ros/wire.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "estancia/core/fail.hpp"

namespace estancia::ros {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t cdrHeader = 4;

std::vector<std::byte> headerOfCdr() {
  return {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
}

}  // namespace

WireReader::WireReader(std::span<const std::byte> message, Encoding encoding)
    : message_(message), encoding_(encoding) {
  if (encoding == Encoding::ros1) return;
  // OMG DDS-XTypes 1.3, table 59: two bytes of representation, two of options.
  const auto header = take(4);
  const int representation = std::to_integer<int>(header[0]) << 8 | std::to_integer<int>(header[1]);
  constexpr int bigEndian = 0x0000, littleEndian = 0x0001, bigEndian2 = 0x0006, littleEndian2 = 0x0007;
  if (representation != bigEndian && representation != littleEndian && representation != bigEndian2 &&
      representation != littleEndian2)
    fail(ErrorCode::unsupportedFile,
         "a message of the CDR representation {:#06x}, which ROS 2 does not use; plain CDR is read",
         representation);
  swaps_ = representation == bigEndian || representation == bigEndian2;
  maxAlignment_ = representation >= bigEndian2 ? 4 : 8;
  origin_ = at_;
}

std::span<const std::byte> WireReader::take(std::size_t size) {
  if (size > message_.size() - at_)
    fail(ErrorCode::truncatedFile,
         "a message of {} bytes ends too early: {} more bytes are wanted at byte {}", message_.size(), size,
         at_);
  const auto taken = message_.subspan(at_, size);
  at_ += size;
  return taken;
}

void WireReader::align(std::size_t size) {
  const std::size_t alignment = std::min(size, maxAlignment_);
  take((alignment - (at_ - origin_) % alignment) % alignment);
}

std::size_t WireReader::count(std::size_t bytes) {
  const std::size_t items = number<std::uint32_t>();
  if (items > (message_.size() - at_) / bytes)
    fail(ErrorCode::truncatedFile, "a message of {} bytes ends too early: it announces {} items at byte {}",
         message_.size(), items, at_);
  return items;
}

std::string WireReader::text() {
  auto bytes = this->bytes();
  if (encoding_ == Encoding::cdr && !bytes.empty() && bytes.back() == std::byte{0})
    bytes = bytes.first(bytes.size() - 1);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::int64_t WireReader::time() {
  // ROS 1 counts seconds without a sign, ROS 2 with one: the same until 2038.
  const std::int64_t seconds = encoding_ == Encoding::ros1 ? std::int64_t{number<std::uint32_t>()}
                                                           : std::int64_t{number<std::int32_t>()};
  return seconds * 1'000'000'000 + number<std::uint32_t>();
}

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
