// Mapping session: maps frames into a map file while they come, and goes on with it later.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/map_file/map.hpp"
#include "estancia/mapper/mapper.hpp"

namespace estancia {

/// In megabytes (10⁶ bytes); without a value, as much as it takes. A map keeps its budget.
struct MapBudget {
  /// Limit for the places, their views and the drive guide, in memory; without the labeling model.
  std::optional<std::uint64_t> memory;
  /// Limit for the map file.
  std::optional<std::uint64_t> file;

  bool operator==(const MapBudget&) const = default;
};
OptionGroup declare(MapBudget& budget);

/// What compactMap() did.
struct CompactedMap {
  std::uintmax_t bytesBefore = 0, bytesAfter = 0;
  std::size_t framesBefore = 0, framesAfter = 0;
};

/// Gives the file's unused space back and, where `fileBudget` [MB] is given, leaves out frames until it fits:
/// of the places with most frames, those most similar to others. Places, objects, areas, names and
/// corrections stay. Throws Error as readMap() does, busy when another process writes the map, and tooLarge
/// when what must stay does not fit.
CompactedMap compactMap(const std::filesystem::path& map, const std::optional<std::uint64_t>& fileBudget);

class Labeler;
class Sequence;

/// How a drive begins in a map of others.
struct DriveStart {
  /// For people: the name of its sequence.
  std::string name = {};
  /// Sequence::fingerprint() of its first frame.
  std::string fingerprint = {};
  /// Whether its poses are in the map's frame, as those of a robot that localizes in a map of its own; else
  /// in any fixed frame.
  bool posesAreInMap = false;
  /// T_map_drive where that is known already.
  std::optional<Pose> alignment = {};
};

/// Maps frames into a file, which is written once a second. After a crash the file holds everything up to the
/// last second, and resuming gives the very map that an unbroken run would have made (but where finish() came
/// before a drive was recognized, see there). The file appears with the first second of frames. One session
/// writes a map at a time; others may read its last second.
class MappingSession {
 public:
  /// A small JPEG of the frame being added; called only for frames whose image is kept.
  using Image = std::function<std::vector<unsigned char>()>;

  /// Creates the map, or goes on with it when the file exists. `labeler` must outlive the session. Throws
  /// Error as create() and resume() do, when `options` are given and are not those of the map (mismatch), and
  /// for a labeler that discovers its words (invalidInput).
  MappingSession(const std::filesystem::path& path, Labeler& labeler,
                 const std::optional<MapperOptions>& options = {});

  /// A new map of descriptors; `model` identifies what made them. Throws Error: fileExists, fileNotFound (the
  /// folder), fileUnwritable; with ExistingMap::replace also when that file is not a map, or is being
  /// written.
  static MappingSession create(const std::filesystem::path& path, const Vocabulary& vocabulary,
                               const std::string& model, const MapperOptions& options,
                               ExistingMap existing = ExistingMap::refuse);

  /// Goes on with a map. Throws Error as readMap() does, busy when another process writes it, and mismatch
  /// when `vocabulary` or `model` is not the map's.
  static MappingSession resume(const std::filesystem::path& path, const Vocabulary& vocabulary,
                               const std::string& model);

  MappingSession(MappingSession&&) noexcept;
  MappingSession& operator=(MappingSession&&) noexcept;
  /// Calls finish(), unless an exception is on its way.
  ~MappingSession();

  /// Bounds the memory and the file from now on, whatever is mapped; the map keeps it. The file may leave out
  /// frames then: those that add the least information to the others of their places. Throws Error
  /// (tooLarge), also later, where what must stay does not fit.
  void setBudget(const MapBudget& budget);
  /// Applies `change` to the budget that the map keeps.
  void changeBudget(const std::function<void(MapBudget&)>& change);
  const MapBudget& budget() const;
  /// The next frame is another drive's: the robot may be anywhere. It is localized in what earlier drives
  /// have mapped; what is not recognized becomes a part of the map of its own, until the robot comes to a
  /// known place. Its poses are known in the map once enough places were recognized; those of earlier frames
  /// follow then.
  void beginDrive(const DriveStart& start = {});
  /// Labels a BGR image of any size, maps it, stores a thumbnail, and returns its place (node id). For
  /// sessions with a labeler.
  int add(const cv::Mat& image, std::optional<double> timestamp = {}, const std::optional<Pose>& pose = {});
  /// Maps a frame that was labeled elsewhere.
  int add(const Frame& frame, DescriptorView descriptor, const Image& image = {});
  /// Where earlier frames were taken, as it is known now, and nothing of those of which it is not.
  struct Correction {
    std::size_t frame;
    std::optional<Pose> pose;
  };
  /// Takes them in place of the poses of add(). Throws Error (unknownName) for frames that the map lacks.
  void correct(const std::vector<Correction>& corrections);
  /// Writes everything, a last remapping of the warm-up included. A drive that was recognized nowhere is
  /// mapped again by its own scale, as if it were the first; where it goes on and is recognized later, it
  /// keeps these places. More frames may follow.
  void finish();

  std::size_t frames() const;
  const Mapper& mapper() const;
  /// The map as of now, to ask or to localize in.
  TopologicalMap map();

 private:
  friend class Localizer;
  friend class WorldMapper;
  friend class NewMap;
  struct Impl;
  explicit MappingSession(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Where in `sequence` the map's last drive goes on, if that was made of its first frames: after the last
/// mapped one. Frames that could not be read are missing in the map. Nothing when the sequence is another
/// drive's: the drive has frames that it does not have, in this order, with these time stamps, or begins with
/// another image.
std::optional<std::size_t> firstUnmapped(const TopologicalMap& map, const Sequence& sequence);

/// How a drive of a sequence begins.
DriveStart driveStartOf(const Sequence& sequence);

/// Stores a room classifier's predictions in a map file, row i for frame i; earlier ones are replaced. Throws
/// Error as readMap() does, and when they do not fit the map (mismatch) or another process writes it (busy).
void writeRoomPredictions(const RoomPredictions& predictions, const std::filesystem::path& path);

}  // namespace estancia
