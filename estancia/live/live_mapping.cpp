// A map that grows while live frames come.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <future>
#include <utility>
#include <variant>

#include "estancia/core/fail.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/files/image_writer.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/live/background_thread.hpp"
#include "estancia/live/live_map.hpp"
#include "estancia/mapper/mapper_impl.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/words/installed_words.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/edit_rules.hpp"
#include "estancia/world_file/world_options.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;

/// Layers are derived in a thread that only takes what others leave, a fifth of a processor at most; copying
/// what they are derived of, and writing them, takes 2 % of the loop's time. And not more often.
constexpr int timesOfDerivation = 5, timesOfRefresh = 50;
constexpr auto shortestPeriod = std::chrono::seconds(1);
/// A map that cannot be written is opened again after so long, and twice as long each time that fails.
constexpr auto firstRetry = std::chrono::seconds(1), longestRetry = std::chrono::seconds(30);

struct DerivedLayers {
  std::shared_ptr<const WorldMapper::Derived> layers;
  std::chrono::nanoseconds took;  // processor time
};

/// Whether the map may be written again some time.
bool mayPass(ErrorCode code) {
  using enum ErrorCode;
  return code == fileUnwritable || code == fileUnreadable || code == busy || code == invalidInput ||
         code == invalidState || code == tooLarge;
}

/// Whether the file is no longer the map that was written, so that to go on would make or change another one.
bool isLostBy(ErrorCode code) {
  using enum ErrorCode;
  return code == fileNotFound || code == unsupportedFile || code == truncatedFile || code == corruptFile;
}

/// The area of a frame; areas are of some seconds ago.
std::pair<int, double> areaOf(const WorldMap* world, const std::optional<Pose>& pose, int node) {
  if (world == nullptr || !world->plan) return {-1, 0};
  const AreaPlan& plan = *world->plan;
  const int area =
      pose ? areaAt(plan, plan.floor.position({pose->x, pose->y, pose->z}), 0.5) : world->areaOfNode(node);
  return {area, area < 0 ? 0 : 1};
}

/// The form in which the map stores an edit. Throws Error if it cannot be applied.
std::variant<AreaEdit, ObjectEdit> anchoredIn(const WorldMap& world, const MapEdit& edit) {
  const auto object = [&](int id) -> const WorldObject& { return getObject(world, std::to_string(id)); };
  return std::visit(
      [&](const auto& what) -> std::variant<AreaEdit, ObjectEdit> {
        using What = std::decay_t<decltype(what)>;
        if constexpr (std::is_same_v<What, NameArea>)
          return namingOf(world, std::to_string(what.area), what.name);
        else if constexpr (std::is_same_v<What, MergeAreas>)
          return mergeOf(world, std::to_string(what.area), std::to_string(what.other));
        else if constexpr (std::is_same_v<What, SplitArea>)
          return splitOf(world, what.from, what.to);
        else if constexpr (std::is_same_v<What, NameObject>)
          return namingOf(object(what.object), what.name);
        else
          return removalOf(object(what.object));
      },
      edit);
}

/// A live map that grows. Invariant: mapper_ exists only with session_; a failed step closes both (Step), and
/// openAgain() goes on from the last commit after a pause. derived_ computes areas and objects in another
/// thread; refresh() takes its result.
class MappingLiveMap final : public LiveMap {
 public:
  MappingLiveMap(FrameSource& source, Labeler& labeler, std::filesystem::path path, LiveOptions options)
      : source_(source), labeler_(labeler), path_(std::move(path)), options_(std::move(options)) {
    const bool exists = std::filesystem::exists(path_);
    open();
    isOnDisk_ = exists;
    world_ = WorldMapper::optionsOf(*session_).value_or(WorldOptions{});
    goneOptions_ = WorldMapper::goneOptionsOf(*session_);
    if (options_.changeWorld) options_.changeWorld(world_);
    if (!exists || !source_.goOnAfter(session_->map())) driveBegins_ = session_->frames();
  }

  void take(const LiveFrame& live, DescriptorView words, const std::shared_ptr<const WorldMap>& world,
            const std::function<void(const LivePlace&)>& placed, const Deadline& deadline) override {
    write([&] {
      if (!mapper_) start();
      const cv::Mat depth = fittingDepth(live);
      const auto thumbnail = [&] { return encodeImage(live.image); };
      const auto tell = [&](int node, const std::optional<Pose>& pose) {
        LivePlace place{pose, {{node, 1}}};
        std::tie(place.area, place.areaProbability) = areaOf(world.get(), pose, node);
        place.decision = lastDecision(live.frame.name);
        placed(place);
      };
      mapper_->add(live.frame, words, live.image, depth, camera_.value_or(CameraIntrinsics{}), thumbnail,
                   tell, deadline);
      ++frames_;
      isStale_ = true;
    });
  }

  bool refresh() override {
    const auto now = Clock::now();
    bool isChanged = false;
    if (derived_.valid()) {
      if (derived_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) isChanged = putDerived();
    } else if (isStale_ && mapper_ && now >= refreshAt_) {
      isStale_ = false;
      derived_ = std::async(std::launch::async, [derive = mapper_->derivation()] {
        takeWhatIsLeft();
        return DerivedLayers{derive(), processorTime()};  // in this order
      });
      copying_ = Clock::now() - now;
    }
    if (isChanged || (frames_ > 0 && now >= tellAt_)) {  // a session writes once a second by itself
      frames_ = 0;
      tellAt_ = now + shortestPeriod;
      return true;
    }
    return false;
  }

  void edit(const MapEdit& edit, const WorldMap& world) override {
    const std::variant<AreaEdit, ObjectEdit> anchored = anchoredIn(world, edit);
    std::exception_ptr refused;
    write([&] {
      if (!mapper_) start();
      try {
        std::visit([this](const auto& correction) { mapper_->edit(correction); }, anchored);
      } catch (const Error& e) {  // it would change nothing, and the map is as it was
        if (e.code() != ErrorCode::invalidInput && e.code() != ErrorCode::insufficientData) throw;
        refused = std::current_exception();
      }
    });
    if (refused) std::rethrow_exception(refused);
  }

  bool namesRooms() const override { return world_.areas.naming.words == NamingOptions::Words::wordNet; }
  bool isLost() const override { return lost_.has_value(); }
  std::vector<std::string> troubles() const override {
    std::vector<std::string> troubles = goneOptions_;
    if (!unwritable_.empty())
      troubles.push_back(
          fmt::format("nothing is mapped for now, but the map is tried again: {}", unwritable_));
    if (!unfitting_.empty()) troubles.push_back(unfitting_);
    return troubles;
  }

  void finish() override {
    if (lost_) throw *lost_;
    if (!session_)
      throw Error(ErrorCode::fileUnwritable,
                  unwritable_.empty() ? path_.string() + " could not be written" : unwritable_);
    derived_ = {};  // is waited for
    {
      const Step step(*this);
      session_->finish();
      if (mapper_) mapper_->finish();
      close();
    }
    if (namesRooms() && std::filesystem::exists(path_)) renewRoomsByNames(path_);
  }

 private:
  /// Drops what was not written where an exception is on its way.
  class Step {
   public:
    explicit Step(MappingLiveMap& map) : map_(map), exceptions_(std::uncaught_exceptions()) {}
    ~Step() {
      if (std::uncaught_exceptions() > exceptions_) map_.close();
    }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    MappingLiveMap& map_;
    int exceptions_;
  };

  void open() {
    const bool exists = std::filesystem::exists(path_);
    if (exists) session_ = MappingSession::resume(path_, labeler_.vocabulary(), labeler_.identity());
    MapperOptions wanted = exists ? session_->mapper().options() : MapperOptions{};
    if (options_.changeMapper) options_.changeMapper(wanted);
    if (!exists) session_ = MappingSession::create(path_, labeler_.vocabulary(), labeler_.identity(), wanted);
    session_->changeBudget(options_.changeBudget);
    if (exists && wanted != session_->mapper().options())
      fail(ErrorCode::mismatch,
           "{} was made with other parameters of the mapper, which it keeps; leave them out, or map anew",
           path_.string());
  }

  void openAgain() {
    if (session_) return;
    if (Clock::now() < retryAt_) throw Error(ErrorCode::fileUnwritable, unwritable_);
    if (isOnDisk_ && !std::filesystem::exists(path_))
      fail(ErrorCode::fileNotFound, "{} was removed or moved while it was being written; map again",
           path_.string());
    open();
  }

  void close() {
    derived_ = {};
    mapper_.reset();
    session_.reset();
  }

  /// The layers wait for the first frame: only then a source knows its camera.
  void start() {
    camera_ = source_.hasDepth() ? source_.intrinsics() : std::nullopt;
    const WorldLayers layers = world_.layers.value_or(WorldLayers{});
    const bool track = camera_ && !source_.hasPoses() && (layers.areas || layers.objects);
    if (driveBegins_ && session_->frames() <= *driveBegins_) {  // also where nothing of it could be written
      DriveStart drive = source_.driveStart();
      drive.posesAreInMap = options_.posesAreInMap || !source_.hasPoses();
      session_->beginDrive(drive);
    }
    mapper_.emplace(*session_, world_, &labeler_, track ? camera_ : std::nullopt);
  }

  bool putDerived() {
    const auto begin = Clock::now();
    const DerivedLayers derived = std::exchange(derived_, {}).get();
    bool isPut = false;
    write([&] { isPut = mapper_->refresh(*derived.layers); });
    const auto inLoop = copying_ + (Clock::now() - begin);
    refreshAt_ = Clock::now() + std::max<Clock::duration>({shortestPeriod, timesOfDerivation * derived.took,
                                                           timesOfRefresh * inLoop});
    if (!isPut) {
      isStale_ = true;
      refreshAt_ = Clock::now();
    }
    return isPut;
  }

  /// Does what writes the map; where that fails for now, the map is opened again later.
  template <class Work>
  void write(const Work& work) {
    if (lost_) throw *lost_;
    try {
      const Step step(*this);
      openAgain();
      work();
      if (!isOnDisk_) isOnDisk_ = std::filesystem::exists(path_);
      if (!unwritable_.empty()) retry_ = firstRetry;
      unwritable_.clear();
    } catch (const Error& e) {
      if (isLostBy(e.code()) && isOnDisk_) lost_ = e;
      if (!mayPass(e.code())) throw;
      if (Clock::now() >= retryAt_) {
        unwritable_ = e.what();
        retryAt_ = Clock::now() + retry_;
        retry_ = std::min<Clock::duration>(2 * retry_, longestRetry);
      }
      throw;
    }
  }

  /// Nothing where it cannot be of the camera that is known.
  cv::Mat fittingDepth(const LiveFrame& live) {
    unfitting_.clear();
    if (!camera_ || live.depth.empty()) return {};
    const double shape = static_cast<double>(camera_->width) / camera_->height,
                 seen = static_cast<double>(live.depth.cols) / live.depth.rows;
    if (std::abs(seen / shape - 1) <= 0.02) return live.depth;
    unfitting_ = fmt::format(
        "depth images of {} × {} pixels are not of the camera that is known, {} × {}: these frames are "
        "mapped without areas and objects",
        live.depth.cols, live.depth.rows, camera_->width, camera_->height);
    return {};
  }

  std::string lastDecision(const std::string& frame) const {
    const auto& events = session_->mapper().impl().changes.events;
    for (auto event = events.rbegin(); event != events.rend(); ++event)
      if (const auto* decision = std::get_if<Decision>(&*event))
        return fmt::format("{}", fmt::join(explain(*decision, frame), " "));
    return "";
  }

  FrameSource& source_;
  Labeler& labeler_;
  std::filesystem::path path_;
  LiveOptions options_;
  WorldOptions world_;
  std::vector<std::string> goneOptions_;  // options of the map that this version lacks, a sentence each
  std::optional<MappingSession> session_;
  std::optional<WorldMapper> mapper_;
  std::optional<CameraIntrinsics> camera_;
  std::size_t frames_ = 0;  // since the last notification of a change
  bool isStale_ = false;    // layers
  Clock::time_point tellAt_ = Clock::now() + shortestPeriod, refreshAt_ = tellAt_, retryAt_;
  Clock::duration copying_{};
  std::future<DerivedLayers> derived_;
  Clock::duration retry_ = firstRetry;
  /// Number of frames mapped before this drive; nothing if the file's last drive goes on.
  std::optional<std::size_t> driveBegins_;
  bool isOnDisk_ = false;      // it has been
  std::optional<Error> lost_;  // why
  std::string unwritable_, unfitting_;
};

}  // namespace

std::unique_ptr<LiveMap> makeMappingLiveMap(FrameSource& source, Labeler& labeler,
                                            const std::filesystem::path& path, const LiveOptions& options) {
  return std::make_unique<MappingLiveMap>(source, labeler, path, options);
}

}  // namespace estancia
