// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/live_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <exception>
#include <future>
#include <nlohmann/json.hpp>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/label_words.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/take_interrupt.hpp"
#include "estancia/labelers/labeler.hpp"
#include "estancia/live/edits.hpp"
#include "estancia/live/live_board.hpp"
#include "estancia/live/live_map.hpp"
#include "estancia/live/live_times.hpp"
#include "estancia/live/world_reader.hpp"
#include "estancia/world/rooms_by_name.hpp"
#include "estancia/world_query/changes.hpp"

namespace estancia {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto patienceForFrames = std::chrono::milliseconds(100);
constexpr std::size_t wordsShown = 8;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

/// run() owns source, labeler and map in one thread: it takes frames and edits until stopped, until the
/// source ends or the map is lost, then writes everything. Other threads read `board`, set `stopping`, and
/// append to `requests` under `edits` while `running`; `reader` posts each map on `board`, and is destroyed
/// before it.
struct LiveLoop::Impl {
  Impl(std::unique_ptr<FrameSource> frames, Labeler& words, std::filesystem::path file,
       const LiveOptions& options)
      : source(std::move(frames)),
        labeler(words),
        path(std::move(file)),
        localize(options.localize),
        map(makeMap(options)),
        // The localizer numbers all frames; a map that grows is read as far as predictions need it.
        reader(
            path,
            localize ? WorldReader::Options{} : WorldReader::Options{maxFramesOfAnswers, map->namesRooms()},
            [this](auto world) { board.setWorld(std::move(world)); }) {
    board.change([this](LiveStatus& status) { status.source = source->name(); });
    if (std::filesystem::exists(path)) reader.wait(reader.request());
  }

  std::unique_ptr<LiveMap> makeMap(const LiveOptions& options) {
    if (labeler.discovers())
      fail(ErrorCode::invalidInput,
           "{} discovers its words, but a live map needs to know them; take another model",
           labeler.identity());
    return localize ? makeLocalizingLiveMap(labeler, path, options)
                    : makeMappingLiveMap(*source, labeler, path, options);
  }

  void run(const std::function<void(const LiveStatus&)>& each) {
    {
      const std::lock_guard lock(edits);
      running = true;
    }
    std::exception_ptr failure;
    try {
      while (!stopping && !interrupted() && !map->isLost()) {
        doEdits();
        if (const auto live = source->newest(patienceForFrames))
          take(*live, each);
        else if (source->ended())
          break;
        else
          idle();
        refresh();
      }
    } catch (const Interrupted&) {  // thrown by a labeler that was asked to stop
    } catch (...) {
      failure = std::current_exception();
    }
    takeInterrupt();  // what was mapped is written whole
    try {
      finish();
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
    if (failure) std::rethrow_exception(failure);
  }

  void take(const LiveFrame& live, const std::function<void(const LiveStatus&)>& each) {
    board.setImage(live.image);
    period.add(live.arrived, live.dropped);
    try {
      const Prepared prepared = labeler.prepare(live.image, live.frame.name);
      const auto begin = Clock::now();
      const LexicalDescriptor words = labeler.infer(prepared);
      forwards.add(millisecondsSince(begin));
      map->take(
          live, words, board.world(),
          [&](const LivePlace& at) {
            place(live, words, at);
            if (each) each(board.status());
          },
          deadlineFor(live));
    } catch (...) {
      lose(live, frameFailure(live.frame.name));
    }
  }

  /// Mapping what a frame shows must not delay the next one by more than a third of the forward pass that
  /// both need. With a camera that is faster than the network, some frame always waits; and no frame waits
  /// longer than the next one takes to come.
  Deadline deadlineFor(const LiveFrame& live) const {
    const auto next = period.value();
    const std::chrono::duration<double, std::milli> pass(forwards.quantile(0.5));
    if (!next ||
        *next < std::max<std::chrono::duration<double, std::milli>>(pass, std::chrono::milliseconds(10)) ||
        source->isOnDemand())
      return std::nullopt;
    return live.arrived + *next + std::chrono::duration_cast<Clock::duration>(pass / 3);
  }

  void place(const LiveFrame& live, DescriptorView words, const LivePlace& at) {
    const double latency = millisecondsSince(live.arrived);
    latencies.add(latency);
    rate.add(Clock::now());
    const auto world = board.world();
    const WorldArea* area = world ? world->findArea(at.area) : nullptr;
    std::vector<LabelProbability> best;
    for (const std::size_t label : bestLabels(words, wordsShown))
      best.push_back({shortLabel(labeler.vocabulary()[label]), words[label]});
    const std::vector<std::string> wrong = troubles();
    board.change([&](LiveStatus& status) {
      status.state = localize ? "localizing" : "mapping";
      status.troubles = wrong;
      ++status.frames;
      status.dropped += live.dropped;
      status.failed = lost + source->unreadable();
      status.frame = live.frame.name;
      status.timestamp = live.frame.timestamp;
      status.pose = at.pose;
      status.words = best;
      status.places = at.places;
      status.area = area == nullptr ? -1 : area->id;
      status.areaProbability = area == nullptr ? 0 : at.areaProbability;
      status.areaName = area == nullptr ? "" : area->displayName();
      status.unmapped = at.unmapped;
      status.decision = at.decision;
      status.latency = latency;
      status.medianLatency = latencies.quantile(0.5);
      status.p95Latency = latencies.quantile(0.95);
      status.forward = forwards.quantile(0.5);
      status.rate = rate.value();
    });
  }

  void lose(const LiveFrame& live, const Error& why) {
    std::vector<std::string> wrong = troubles();
    if (wrong.empty()) wrong.emplace_back(why.what());
    ++lost;
    board.change([&](LiveStatus& status) {
      status.troubles = wrong;
      status.dropped += live.dropped;
      status.failed = lost + source->unreadable();
    });
  }

  /// No frame came.
  void idle() {
    const std::vector<std::string> wrong = troubles();
    const LiveStatus now = board.status();
    const bool isStale = !wrong.empty() || now.frames == 0;
    const std::string state = isStale ? "waiting" : now.state;
    const std::size_t failed = lost + source->unreadable();
    if (now.state == state && now.troubles == wrong && now.failed == failed) return;
    board.change([&](LiveStatus& status) {
      status.failed = failed;
      status.state = state;
      status.troubles = wrong;
    });
  }

  std::vector<std::string> troubles() const {
    std::vector<std::string> all = map->troubles();
    if (const std::string trouble = source->trouble(); !trouble.empty()) all.push_back(trouble);
    return all;
  }

  void doEdits() {
    for (;;) {
      Request request;
      {
        const std::lock_guard lock(edits);
        if (requests.empty()) return;
        request = std::move(requests.front());
        requests.pop_front();
      }
      try {
        doEdit(request.edit, request.mapRevision);
        request.done.set_value();
      } catch (...) {
        request.done.set_exception(std::current_exception());
      }
    }
  }

  /// Until world() has it.
  void doEdit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) {
    const std::lock_guard one(editing);
    const auto [world, revision] = board.worldAndRevision();
    requireRevision(mapRevision, revision);
    if (!world) fail(ErrorCode::insufficientData, "there is no map yet; wait for its first second");
    if (map)
      map->edit(edit, *world);
    else
      editMapFile(path, edit);
    reader.wait(reader.request());
  }

  void refresh() {
    try {
      if (map->refresh()) reader.request();
    } catch (...) {
      const std::string why = frameFailure("the map").what();
      board.change([&](LiveStatus& status) { status.troubles = {why}; });
    }
  }

  void finish() {
    std::exception_ptr failure;
    try {
      map->finish();
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::lock_guard lock(edits);
      map.reset();
      running = false;
    }
    doEdits();  // edits that came meanwhile
    if (std::filesystem::exists(path)) reader.wait(reader.request());
    board.change([](LiveStatus& status) { status.state = "ended"; });
    if (failure) std::rethrow_exception(failure);
  }

  std::unique_ptr<FrameSource> source;
  Labeler& labeler;
  const std::filesystem::path path;
  const bool localize;
  LiveBoard board;
  std::unique_ptr<LiveMap> map;
  WorldReader reader;  // after the board, which it uses
  std::atomic<bool> stopping = false;
  RecentNumbers latencies, forwards;
  RecentRate rate;
  FramePeriod period;
  std::size_t lost = 0;  // frames that came, and could not be used

  struct Request {
    MapEdit edit;
    std::optional<std::uint64_t> mapRevision;
    std::promise<void> done;
  };
  std::mutex edits, editing;
  bool running = false;          // takes requests
  std::deque<Request> requests;  // requests of other threads
};

LiveLoop::LiveLoop(std::unique_ptr<FrameSource> source, Labeler& labeler, std::filesystem::path map,
                   const LiveOptions& options)
    : impl_(std::make_unique<Impl>(std::move(source), labeler, std::move(map), options)) {}
LiveLoop::~LiveLoop() = default;

void LiveLoop::run(const std::function<void(const LiveStatus&)>& each) {
  if (!impl_->map) fail(ErrorCode::invalidState, "a live loop runs once; make another one");
  impl_->run(each);
}

void LiveLoop::stop() {
  impl_->stopping = true;
}

LiveStatus LiveLoop::status() const {
  return impl_->board.status();
}

LiveStatus LiveLoop::waitForChange(std::uint64_t revision, std::chrono::milliseconds patience) const {
  return impl_->board.waitForChange(revision, patience);
}

std::shared_ptr<const std::vector<unsigned char>> LiveLoop::image() const {
  return impl_->board.image();
}

std::shared_ptr<const WorldMap> LiveLoop::world() const {
  return impl_->board.world();
}

std::vector<unsigned char> LiveLoop::objectImage(int object) const {
  return world() ? readObjectImage(impl_->path, object) : std::vector<unsigned char>();
}

std::vector<unsigned char> LiveLoop::placeImage(int node) const {
  const auto now = world();
  return now ? readPlaceImage(impl_->path, *now, node) : std::vector<unsigned char>();
}

nlohmann::ordered_json LiveLoop::changes(const std::optional<std::size_t>& since) const {
  if (!world()) fail(ErrorCode::insufficientData, "there is no map yet; wait for the first images");
  return toJson(findChanges(impl_->path, since));
}

void LiveLoop::edit(const MapEdit& edit, const std::optional<std::uint64_t>& mapRevision) {
  Impl& impl = *impl_;
  std::future<void> done;
  {
    const std::lock_guard lock(impl.edits);
    if (impl.running) {
      impl.requests.push_back({edit, mapRevision, {}});
      done = impl.requests.back().done.get_future();
    } else {
      impl.doEdit(edit, mapRevision);  // no thread is at work on the map
    }
  }

  if (done.valid()) done.get();
}

}  // namespace estancia
