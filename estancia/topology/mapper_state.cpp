// What the mapper writes into the map file, so that a run can go on where it stopped.
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/topology/mapper.hpp"

namespace estancia {
namespace {

using Json = nlohmann::json;

constexpr const char* damaged = "the map's saved mapper state is damaged; map again";

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::vector<float>& values) {
    put<std::uint64_t>(values.size());
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  }
  std::string bytes;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  T get() {
    T value;
    const auto from = take(sizeof value);
    std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  std::vector<float> getFloats(std::size_t most) {
    const auto count = get<std::uint64_t>();
    if (count > most) throw Error(damaged);
    const auto from = take(count * sizeof(float));
    std::vector<float> values(count);
    if (count > 0) std::memcpy(values.data(), from.data(), from.size());
    return values;
  }
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw Error(damaged);
    const auto front = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return front;
  }
  void requireEnd() const {
    if (!rest_.empty()) throw Error(damaged);
  }

 private:
  std::string_view rest_;
};

}  // namespace

MapperOptions MapperOptions::thesis() {
  MapperOptions options;
  options.distance = "weighted-root";
  options.tauJoin = 0.015;
  options.tauRevisit = 0.015;
  options.transitionImages = 15;
  options.thresholds.mergeRatio = 0;
  return options;
}

std::string MapperOptions::toJson() const {
  Json json{{"distance", distance},
            {"nearer_than_current", nearerThanCurrent},
            {"blur_images", transitionImages},
            {"settle_frames", warmupFrames},
            {"far_quantile", thresholds.farQuantile},
            {"revisit_ratio", thresholds.revisitRatio},
            {"merge_ratio", thresholds.mergeRatio}};
  if (tauJoin) json["tau_join"] = *tauJoin;
  if (tauRevisit) json["tau_revisit"] = *tauRevisit;
  return json.dump();
}

MapperOptions MapperOptions::fromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    MapperOptions options;
    options.distance = printable(json.at("distance").get<std::string>());
    json.at("nearer_than_current").get_to(options.nearerThanCurrent);
    json.at("blur_images").get_to(options.transitionImages);
    json.at("settle_frames").get_to(options.warmupFrames);
    json.at("far_quantile").get_to(options.thresholds.farQuantile);
    json.at("revisit_ratio").get_to(options.thresholds.revisitRatio);
    json.at("merge_ratio").get_to(options.thresholds.mergeRatio);
    if (json.contains("tau_join")) options.tauJoin = json["tau_join"].get<double>();
    if (json.contains("tau_revisit")) options.tauRevisit = json["tau_revisit"].get<double>();
    return options;
  } catch (const Json::exception& e) {
    throw Error(std::string("the map's settings cannot be read (") + printable(e.what()) + "); map again");
  }
}

std::string Mapper::state() const {
  Writer out;
  const ThresholdEstimator::Memory seen = scale_.memory();
  out.put<std::uint64_t>(seen.frames);
  out.put<std::uint64_t>(seen.keyframes);
  out.put<std::uint64_t>(seen.views);
  out.put<std::uint64_t>(seen.lastView);
  out.put<std::uint64_t>(seen.repeats);
  out.put<std::uint64_t>(seen.sampled.size());
  for (const auto& [keyframe, frame] : seen.sampled) {
    out.put<std::uint64_t>(keyframe);
    out.put<std::uint64_t>(frame);
  }
  out.put<std::uint64_t>(nextRescale_);
  out.put<std::int32_t>(currentNode());
  out.put<std::int32_t>(nextId_);
  out.put<std::uint64_t>(stay_);
  out.put(thresholds_);
  out.put(bank_.standardization().center);
  out.put(bank_.standardization().weight);
  out.bytes += scale_.moments().toBytes();
  out.put<std::uint64_t>(transitions_.size());
  for (const auto& entry : transitions_) out.put(entry.second);
  return out.bytes;
}

std::string Mapper::nodeState(std::size_t slot) const {
  const NodeMemory& node = bank_[slot];
  Writer out;
  out.put<std::uint64_t>(node.frames);
  out.put<std::uint64_t>(node.nextMergeCheck);
  out.bytes += node.words.toBytes();
  if (node.embedded) out.bytes += node.embedded->toBytes();
  return out.bytes;
}

Mapper Mapper::restore(const DescriptorLayout& layout, MapperOptions options, const std::string& state,
                       const std::vector<std::pair<int, std::string>>& nodes,
                       const std::function<LexicalDescriptor(std::size_t)>& descriptor) {
  const std::size_t labels = layout.labels();
  Mapper mapper(layout, std::move(options));
  Reader in(state);
  ThresholdEstimator::Memory seen;
  const auto frames = seen.frames = in.get<std::uint64_t>();
  seen.keyframes = in.get<std::uint64_t>();
  seen.views = in.get<std::uint64_t>();
  seen.lastView = in.get<std::uint64_t>();
  seen.repeats = in.get<std::uint64_t>();
  for (auto count = in.get<std::uint64_t>(); count > 0; --count) {
    const auto keyframe = in.get<std::uint64_t>();
    seen.sampled.emplace(keyframe, in.get<std::uint64_t>());
  }
  mapper.nextRescale_ = in.get<std::uint64_t>();
  const auto current = in.get<std::int32_t>();
  mapper.nextId_ = in.get<std::int32_t>();
  mapper.stay_ = in.get<std::uint64_t>();
  mapper.thresholds_ = in.get<Thresholds>();
  Standardization standardization;
  standardization.center = in.getFloats(labels);
  standardization.weight = in.getFloats(labels);
  const std::size_t expected = mapper.distance_.standardized && frames > 0 ? labels : 0;
  if (standardization.center.size() != expected || standardization.weight.size() != expected)
    throw Error(damaged);
  Moments moments = Moments::fromBytes(in.take(Moments::byteCount(labels, true)), labels, true);
  for (auto count = in.get<std::uint64_t>(); count > 0; --count) {
    const auto transition = in.get<Transition>();
    mapper.transitions_[{transition.from, transition.to}] = transition;
  }
  in.requireEnd();

  mapper.bank_.setStandardization(std::move(standardization));
  for (const auto& [id, bytes] : nodes) {
    Reader node(bytes);
    NodeMemory memory = mapper.bank_.makeNode(id);
    memory.frames = node.get<std::uint64_t>();
    memory.nextMergeCheck = node.get<std::uint64_t>();
    memory.words = Moments::fromBytes(node.take(Moments::byteCount(labels, true)), labels, true);
    if (memory.embedded) {
      const bool spread = mapper.distance_.sigmaWeighted;
      memory.embedded = Moments::fromBytes(node.take(Moments::byteCount(labels, spread)), labels, spread);
    }
    node.requireEnd();
    mapper.bank_.add(std::move(memory));
  }
  if (frames > 0) mapper.current_ = mapper.bank_.slotOf(current);

  mapper.scale_.restore(std::move(seen), std::move(moments), descriptor);
  if (mapper.isWarmingUp())
    for (std::size_t frame = 0; frame < frames; ++frame) mapper.young_.push_back(descriptor(frame));
  const std::size_t recent = std::min<std::size_t>(mapper.options_.transitionImages, mapper.stay_);
  for (std::size_t frame = frames - std::min<std::size_t>(recent, frames); frame < frames; ++frame)
    mapper.recent_.push_back(mapper.makeImage(descriptor(frame)));
  return mapper;
}

}  // namespace estancia
