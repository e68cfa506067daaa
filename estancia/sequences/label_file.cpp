// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/label_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "estancia/core/bytes.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/core/printable_labels.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view magic = "ESTLABEL";
constexpr std::uint32_t version = 1;
constexpr std::size_t maxBytes = std::size_t{64} << 30;

void write(ByteWriter& out, const Frame& frame) {
  out.text(frame.name);
  out.text(frame.room);
  out.number(static_cast<std::uint8_t>((frame.timestamp ? 1 : 0) | (frame.pose ? 2 : 0)));
  if (frame.timestamp) out.number(*frame.timestamp);
  if (const auto& p = frame.pose)
    for (const double value : {p->x, p->y, p->z, p->qx, p->qy, p->qz, p->qw}) out.number(value);
}

Frame readFrame(ByteReader& in) {
  Frame frame;
  frame.name = printable(in.text());
  frame.room = printable(in.text());
  const auto known = in.number<std::uint8_t>();
  if ((known & 1) != 0) frame.timestamp = in.number<double>();
  if (frame.timestamp && !std::isfinite(*frame.timestamp)) in.fail("it is damaged (a time is not finite)");
  if ((known & 2) != 0) {
    Pose& p = frame.pose.emplace();
    for (double* value : {&p.x, &p.y, &p.z, &p.qx, &p.qy, &p.qz, &p.qw}) *value = in.number<double>();
    if (!p.isPlausible()) in.fail("it is damaged (a pose is not finite, or beyond 10 000 km)");
  }
  return frame;
}

}  // namespace

void writeLabelFile(const DescriptorSequence& sequence, const fs::path& file) {
  ByteWriter out;
  out.raw(magic);
  out.number(version);
  out.raw(sequence.vocabulary.digest());
  out.text(sequence.model);
  out.number(static_cast<std::uint64_t>(sequence.vocabulary.size()));
  for (const std::string& label : sequence.vocabulary.labels()) out.text(label);
  const auto& parts = sequence.vocabulary.layout().parts;
  out.number(static_cast<std::uint64_t>(parts.size()));
  for (const LabelPart& part : parts) {
    out.number(static_cast<std::uint64_t>(part.size));
    out.number(part.weight);
  }
  out.number(static_cast<std::uint64_t>(sequence.frames.size()));
  for (const Frame& frame : sequence.frames) write(out, frame);
  const auto values = std::span(sequence.descriptors.values());
  out.raw({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  writeWhole(file, out.bytes());
}

DescriptorSequence readLabelFile(const fs::path& file) {
  const std::string bytes = readBytes(file, maxBytes);
  ByteReader in(bytes, printable(file), "label the sequence again");
  if (!bytes.starts_with(magic))
    fail(ErrorCode::unsupportedFile, "{}: not a label file; give one that `estancia label` has written",
         printable(file));
  in.raw(magic.size());
  if (const auto found = in.number<std::uint32_t>(); found != version)
    fail(ErrorCode::unsupportedFile,
         "{}: label file of version {}; this program reads version {}; update Estancia", printable(file),
         found, version);
  const std::string digest(in.raw(64));
  std::string model = printable(in.text());
  const auto labelCount = in.number<std::uint64_t>();
  if (labelCount == 0 || labelCount > in.remaining()) in.fail("it is truncated", ErrorCode::truncatedFile);
  std::vector<std::string> labels;
  for (std::uint64_t i = 0; i < labelCount; ++i) labels.push_back(in.text());
  const auto partCount = in.number<std::uint64_t>();
  if (partCount > labelCount) in.fail("it is damaged (more parts than labels)");
  std::vector<LabelPart> parts;
  for (std::uint64_t i = 0; i < partCount; ++i) {
    const auto size = in.number<std::uint64_t>();
    parts.push_back({std::min(size, labelCount + 1), in.number<float>()});
  }
  Vocabulary vocabulary(std::move(labels), std::move(parts));
  if (vocabulary.digest() != digest)
    in.fail("it is damaged (labels and digest disagree)", ErrorCode::corruptFile);
  const auto frameCount = in.number<std::uint64_t>();
  if (frameCount > in.remaining()) in.fail("it is truncated", ErrorCode::truncatedFile);
  std::vector<Frame> frames;
  for (std::uint64_t i = 0; i < frameCount; ++i) frames.push_back(readFrame(in));

  DescriptorMatrix descriptors(vocabulary.size());
  const std::size_t rowBytes = vocabulary.size() * sizeof(float);
  if (in.remaining() / rowBytes != frameCount || in.remaining() % rowBytes != 0)
    in.fail("it is truncated", ErrorCode::truncatedFile);
  descriptors.reserve(frames.size());
  LexicalDescriptor row(vocabulary.size());
  for (const Frame& frame : frames) {
    std::memcpy(row.data(), in.raw(rowBytes).data(), rowBytes);
    requireProbabilities(row, row.size(), fmt::format("{}: {}", printable(file), frame.name));
    descriptors.append(row);
  }
  return {printableLabels(vocabulary), std::move(model), std::move(frames), std::move(descriptors)};
}

}  // namespace estancia::io
