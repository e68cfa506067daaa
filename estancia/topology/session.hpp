// A mapping run with its map file: what the mapper decides reaches the disk once a second.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/mapper.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

/// Maps frames into a file. After a crash the file holds everything up to the last second and resume() goes
/// on from there, with the very map that an unbroken run would have made.
class MappingSession {
 public:
  /// A small JPEG of the frame being added; called only for frames whose image is kept.
  using Image = std::function<std::vector<unsigned char>()>;

  /// The file appears with the first second of frames. Throws Error as MapStore::create() does.
  static MappingSession create(const std::filesystem::path& path, const Vocabulary& vocabulary,
                               const std::string& model, const MapperOptions& options,
                               MapStore::Existing existing = MapStore::Existing::refuse);

  /// Goes on with a map. Throws Error as MapStore::open() does, and when `vocabulary` or `model` is not the
  /// map's.
  static MappingSession resume(const std::filesystem::path& path, const Vocabulary& vocabulary,
                               const std::string& model);

  std::size_t frames() const { return mapper_.frames(); }
  const Mapper& mapper() const { return mapper_; }

  void add(const Frame& frame, DescriptorView descriptor, const Image& image = {});
  /// Writes everything, with the last word on a young run. More frames may follow.
  void finish();

 private:
  MappingSession(MapStore store, Mapper mapper);
  void write();

  MapStore store_;
  Mapper mapper_;
  std::chrono::steady_clock::time_point lastWritten_ = std::chrono::steady_clock::now();
};

/// Where in `sequence` a map made of its first frames goes on: after the last mapped one. Frames that could
/// not be read are missing in the map. Throws Error when the map's frames are not frames of this sequence in
/// this order.
std::size_t firstUnmapped(const TopologicalMap& map, const Sequence& sequence);

/// A map file with all that reading it needs.
class MapReader {
 public:
  explicit MapReader(const std::filesystem::path& path);
  const TopologicalMap& map() const { return map_; }
  const MapStore& store() const { return store_; }
  const Mapper& mapper() const { return mapper_; }
  /// What a Localizer needs; it refers to this reader. Compares with at most `mostImages` stored images.
  LocalizerMap forLocalizer(std::size_t mostImages) const;

 private:
  MapStore store_;
  TopologicalMap map_;
  Mapper mapper_;
};

}  // namespace estancia
