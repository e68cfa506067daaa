// Map file: one SQLite database `*.estancia`, written while the robot drives. Private; see readMap().
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/map_file/map.hpp"

namespace estancia {

namespace sqlite {
class Database;
}

/// In SQLite's header: "Esta".
constexpr std::int64_t mapApplicationId = 0x45737461;

/// A map on disk. Everything written since the last commit() is lost together when the process dies, never in
/// part. One writer at a time; readers may look at the last commit meanwhile (WAL).
class MapStore {
 public:
  enum class Access { read, write };
  static constexpr std::size_t allFrames = std::numeric_limits<std::size_t>::max();

  /// Constants of a map.
  struct Identity {
    Vocabulary vocabulary;
    /// Labeler::identity().
    std::string model;
    /// The mapper's settings as JSON.
    std::string settings;
  };

  /// Makes a new file; it exists on disk from the first commit() on. Throws Error: fileNotFound (its folder),
  /// fileUnwritable (read-only or full), fileExists; with ExistingMap::replace unsupportedFile when that file
  /// is not a map, and busy when another process writes it. The older map goes with the first commit().
  static MapStore create(const std::filesystem::path& path, const Identity& identity,
                         ExistingMap existing = ExistingMap::refuse);

  /// Throws Error: fileNotFound, unsupportedFile (another program's file, another format version),
  /// truncatedFile, corruptFile, busy (Access::write).
  static MapStore open(const std::filesystem::path& path, Access access);

  MapStore(MapStore&&) noexcept;
  MapStore& operator=(MapStore&&) noexcept;
  /// Drops what was not committed.
  ~MapStore();

  const Identity& identity() const;

  // ---- writing
  /// Keeps frame.number, which must be none before; those in between are left out unless they follow.
  void addFrame(const MappedFrame& frame, DescriptorView descriptor);
  /// Where the frame was taken, as it is known now.
  void putPose(std::size_t frame, const std::optional<Pose>& pose);
  /// The pose of a frame as it was given, in its drive's own frame.
  void putGivenPose(std::size_t frame, const Pose& pose);
  /// Inserts, or replaces the one that begins at the same frame.
  void putDrive(const Drive& drive);
  /// A small JPEG of a frame, for reports.
  void putImage(std::size_t frame, const std::vector<unsigned char>& jpeg);
  /// Inserts or replaces; `state` is the mapper's own memory of the node.
  void putNode(const Node& node, const std::string& state);
  void putTransition(const Transition& transition);
  void removeTransition(int from, int to);
  /// Sets the frame's node, too.
  void putDecision(const Decision& decision);
  /// Moves all frames of merge.absorbed to merge.kept and removes the absorbed node.
  void addMerge(const Merge& merge);
  /// Forgets the nodes from an id on, their transitions and merges, and what was decided of the frames from a
  /// number on (not these frames): a new mapping of these follows.
  void clearMap(int firstNode = 0, std::size_t firstFrame = 0);
  /// A room classifier's predictions, row i of frame i; earlier ones are replaced. Throws Error (mismatch)
  /// when there are more rows than frames, a room has no name, or a value is not a probability.
  void putPredictions(const RoomPredictions& predictions);
  /// Forgets these frames, and whatever is known of one of them alone: rows of all tables whose primary key
  /// begins with `frame`. Their numbers are not used again.
  void leaveOut(const std::vector<std::size_t>& frames);
  /// Named blobs of the mapper's memory, replaced.
  void putState(const std::string& key, const std::string& bytes);
  void commit();
  /// Commits, and makes the file as small as what it holds.
  void compact();
  /// The connection, for the tables of layers above this one: what is written through it is committed and
  /// lost together with the rest. The first commit() ends the life of its statements.
  sqlite::Database& database();

  // ---- reading
  const std::filesystem::path& path() const;
  /// Until endReading() all is read as of one moment, whatever another process writes. For Access::read.
  void beginReading();
  void endReading();
  /// Bytes in use in the file, without free pages.
  std::uint64_t bytes() const;
  /// The number that the next frame will have. Fewer may be kept.
  std::size_t frameCount() const;
  /// Numbers of the kept frames, in order.
  std::vector<std::size_t> frameNumbers() const;
  /// Frames that a map read in part should have: the first ones of drives, and three of each place.
  std::vector<std::size_t> namedFrames() const;
  /// Visits of all kept frames.
  std::vector<Visit> visits() const;
  /// `maxFrames`: of a longer drive each n-th frame is read, so that there are no more, and those in `also`;
  /// no decisions then.
  TopologicalMap load(std::size_t maxFrames = allFrames, const std::vector<std::size_t>& also = {}) const;
  /// Their first frames are numbers. They touch nodes of any number.
  std::vector<Transition> transitions() const;
  std::optional<std::string> findState(const std::string& key) const;
  /// (node id, state) in order of id.
  std::vector<std::pair<int, std::string>> nodeStates() const;
  /// Throws Error (unknownName) when there is no such frame.
  LexicalDescriptor descriptor(std::size_t frame) const;
  std::optional<Pose> pose(std::size_t frame) const;
  /// Nothing where none was given, or it was in the map's frame.
  std::optional<Pose> givenPose(std::size_t frame) const;
  /// Whether a frame of the map has a pose.
  bool hasPoses() const;
  /// In order of frames; none in maps of older programs.
  std::vector<Drive> drives() const;
  /// Name, time stamp and pose. Throws Error (unknownName) when there is no such frame.
  Frame frame(std::size_t frame) const;
  /// The descriptors of kept frames from number `first` on, in order, until `visit` returns false.
  void forEachDescriptor(std::size_t first,
                         const std::function<bool(std::size_t, DescriptorView)>& visit) const;
  /// Frames with an image, and the image (empty when there is none).
  std::vector<std::size_t> imageFrames() const;
  std::vector<unsigned char> image(std::size_t frame) const;

 private:
  struct Impl;
  explicit MapStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia
