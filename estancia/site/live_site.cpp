// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/live_site.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/printable.hpp"
#include "estancia/live/edits.hpp"
#include "estancia/report/page_assets.hpp"
#include "estancia/site/site_assets.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

ServerResponse jsonResponse(const Json& json, int status = 200) {
  return {status, "application/json", textOf(json)};
}

ServerResponse failureResponse(int status, std::string_view code, std::string_view message) {
  return jsonResponse({{"error", {{"code", code}, {"message", printable(message)}}}}, status);
}

int statusFor(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalidInput:
    case ErrorCode::invalidOption:
      return 400;
    case ErrorCode::unknownName:
    case ErrorCode::noAnswer:
    case ErrorCode::fileNotFound:
      return 404;
    case ErrorCode::busy:
    case ErrorCode::insufficientData:
    case ErrorCode::invalidState:
    case ErrorCode::mismatch:
      return 409;
    default:
      return 500;
  }
}

std::string_view codeFor(int status) {
  switch (status) {
    case 401:
      return "unauthorized";
    case 403:
      return "forbidden";
    case 405:
      return "method-not-allowed";
    case 415:
      return "wrong-type";
    case 503:
      return "too-many";
    default:
      return "not-found";
  }
}

ServerResponse refused(int status, std::string_view why) {
  return failureResponse(status, codeFor(status), why);
}

/// 204 where there is none: a page may ask for what may be there.
ServerResponse imageResponse(const std::vector<unsigned char>& jpeg) {
  if (jpeg.empty()) return {204};
  return {200, "image/jpeg", {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}};
}

/// Adds security headers to every answer: scripts and styles come from this server only, and other pages
/// cannot show it in a frame.
void addSafety(ServerResponse& response) {
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, const char*>>{
           {"Content-Security-Policy",
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src "
            "'self'; "
            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
           {"X-Content-Type-Options", "nosniff"},
           {"X-Frame-Options", "DENY"},
           {"Referrer-Policy", "no-referrer"},
           {"Cross-Origin-Resource-Policy", "same-origin"},
           {"Cache-Control", "no-store"}})
    response.headers.emplace_back(name, value);
}

/// A stream's place among LiveSite::maxStreams.
class StreamSlot {
 public:
  explicit StreamSlot(std::shared_ptr<std::atomic<int>> count) : count_(std::move(count)) {
    isFree_ = count_->fetch_add(1) < LiveSite::maxStreams;
  }
  ~StreamSlot() { count_->fetch_sub(1); }
  StreamSlot(const StreamSlot&) = delete;
  StreamSlot& operator=(const StreamSlot&) = delete;
  bool isFree() const { return isFree_; }

 private:
  std::shared_ptr<std::atomic<int>> count_;
  bool isFree_ = false;
};

}  // namespace

/// A request of the API, whose parameters must be known and fit.
struct LiveSite::Question {
  const ServerRequest& request;
  /// Number in the path: "{node}".
  int number = 0;

  void requireKnown(std::initializer_list<std::string_view> known) const {
    for (const auto& [name, value] : request.query) {
      if (name == "token") continue;
      if (std::ranges::find(known, name) == known.end())
        fail(ErrorCode::invalidInput, "there is no parameter \"{}\" here{}", printable(name),
             known.size() == 0 ? "" : fmt::format("; there are {}", fmt::join(known, ", ")));
      if (value.size() > 1000)
        fail(ErrorCode::invalidInput, "\"{}\" is longer than 1,000 bytes", printable(name));
    }
  }
  std::string text(const std::string& name) const {
    const auto found = request.query.find(name);
    if (found == request.query.end() || found->second.empty() || request.query.count(name) > 1)
      fail(ErrorCode::invalidInput, "give the parameter \"{}\", once", name);
    return found->second;
  }
  std::optional<int> numberOf(const std::string& name, int least, int most) const {
    if (!request.query.contains(name)) return std::nullopt;
    const std::string given = text(name);
    int value = 0;
    const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (problem != std::errc{} || end != given.data() + given.size() || value < least || value > most)
      fail(ErrorCode::invalidInput, "\"{}\" must be a whole number from {} to {}", name, least, most);
    return value;
  }
  std::vector<std::string> texts(const std::string& name) const {
    std::vector<std::string> values;
    const auto [first, last] = request.query.equal_range(name);
    for (auto at = first; at != last; ++at) values.push_back(at->second);
    return values;
  }
};

struct LiveSite::Operation {
  std::string method, path;
  ServerResponse (*answer)(LiveSite& site, const Question& question);

  /// The number in the path; -1 where it has none, nothing where it is another path.
  std::optional<int> match(std::string_view asked) const {
    const std::size_t open = path.find('{');
    if (open == std::string::npos) return asked == path ? std::optional(-1) : std::nullopt;
    const std::string_view before = std::string_view(path).substr(0, open),
                           after = std::string_view(path).substr(path.find('}') + 1);
    if (asked.size() <= before.size() + after.size() || !asked.starts_with(before) || !asked.ends_with(after))
      return std::nullopt;
    asked = asked.substr(before.size(), asked.size() - before.size() - after.size());
    int number = 0;
    const auto [end, problem] = std::from_chars(asked.data(), asked.data() + asked.size(), number);
    if (problem != std::errc{} || end != asked.data() + asked.size() || number < 0) return std::nullopt;
    return number;
  }
};

/// One function a path.
struct SiteOperations {
  using Question = LiveSite::Question;
  static constexpr int anyNumber = std::numeric_limits<int>::max();

  static ServerResponse status(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return jsonResponse(site.queries_.status());
  }
  static ServerResponse where(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return jsonResponse(site.queries_.where());
  }
  static ServerResponse ask(LiveSite& site, const Question& question) {
    question.requireKnown({"words", "max"});
    const int most = question.numberOf("max", 1, 100).value_or(10);
    return jsonResponse(site.queries_.ask(question.text("words"), static_cast<std::size_t>(most)));
  }
  static ServerResponse route(LiveSite& site, const Question& question) {
    question.requireKnown({"to", "from", "avoid", "prefer"});
    return jsonResponse(site.queries_.route({question.text("to"), question.numberOf("from", 0, anyNumber),
                                             question.texts("avoid"), question.texts("prefer")}));
  }
  static ServerResponse objects(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return jsonResponse(site.queries_.objects());
  }
  static ServerResponse areas(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return jsonResponse(site.queries_.areas());
  }
  static ServerResponse changes(LiveSite& site, const Question& question) {
    question.requireKnown({"since"});
    const auto since = question.numberOf("since", 1, anyNumber);
    return jsonResponse(
        site.queries_.changes(since ? std::optional(static_cast<std::size_t>(*since)) : std::nullopt));
  }
  static ServerResponse map(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return {200, "application/json", *site.queries_.map()};
  }
  static ServerResponse place(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return jsonResponse(site.queries_.place(question.number));
  }
  static ServerResponse frameImage(LiveSite& site, const Question& question) {
    question.requireKnown({"revision"});  // a new name for each frame keeps browsers from showing an old one
    const auto image = site.view_.image();
    return imageResponse(image == nullptr ? std::vector<unsigned char>() : *image);
  }
  static ServerResponse objectImage(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return imageResponse(site.view_.objectImage(question.number));
  }
  static ServerResponse placeImage(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return imageResponse(site.view_.placeImage(question.number));
  }
  static ServerResponse events(LiveSite& site, const Question& question) {
    question.requireKnown({});
    return site.events(question.request);
  }
  static ServerResponse edit(LiveSite& site, const Question& question) {
    question.requireKnown({"map_revision"});
    const MapEdit wanted = parseEdit(question.request.body);
    const auto seen = question.numberOf("map_revision", 0, anyNumber);
    site.view_.edit(wanted, seen ? std::optional(static_cast<std::uint64_t>(*seen)) : std::nullopt);
    return jsonResponse({{"map_revision", site.view_.status().mapRevision}});
  }
  static ServerResponse description(LiveSite&, const Question& question) {
    question.requireKnown({});
    return {200, "application/json", openApi};
  }
};

const std::vector<LiveSite::Operation>& LiveSite::all() {
  using Of = SiteOperations;
  static const std::vector<Operation> operations{{"GET", "/api/status", Of::status},
                                                 {"GET", "/api/where", Of::where},
                                                 {"GET", "/api/ask", Of::ask},
                                                 {"GET", "/api/route", Of::route},
                                                 {"GET", "/api/objects", Of::objects},
                                                 {"GET", "/api/areas", Of::areas},
                                                 {"GET", "/api/changes", Of::changes},
                                                 {"GET", "/api/map", Of::map},
                                                 {"GET", "/api/places/{node}", Of::place},
                                                 {"GET", "/api/frame.jpg", Of::frameImage},
                                                 {"GET", "/api/objects/{object}.jpg", Of::objectImage},
                                                 {"GET", "/api/places/{node}.jpg", Of::placeImage},
                                                 {"GET", "/api/events", Of::events},
                                                 {"POST", "/api/edits", Of::edit},
                                                 {"GET", "/api/openapi.json", Of::description}};
  return operations;
}

std::vector<std::string> LiveSite::operations() {
  std::vector<std::string> names;
  for (const Operation& operation : all()) names.push_back(operation.method + " " + operation.path);
  return names;
}

void LiveSite::open(const SiteAccess& access) {
  const std::lock_guard lock(mutex_);
  access_ = access;
}

std::optional<ServerResponse> LiveSite::refusal(const ServerRequest& head) {
  std::optional<SiteAccess> access;
  {
    const std::lock_guard lock(mutex_);
    access = access_;
  }
  if (!access) return refused(503, "the server is starting");
  std::optional<ServerResponse> response;
  if (const auto why = accessRefusal(head, *access))
    response = refused(why->status, why->why);
  else if (head.method != "GET" && head.method != "POST")
    response = refused(405, "this server knows GET and POST");
  else if (head.method == "POST" && head.path != "/api/edits")
    response = refused(405, "changes are sent to /api/edits");
  if (response) addSafety(*response);
  return response;
}

namespace {

/// The page itself: nothing else is a file, and nothing is read from a disk.
std::optional<ServerResponse> pageFile(const std::string& path) {
  constexpr const char* script = "text/javascript; charset=utf-8";
  if (path == "/") return ServerResponse{200, "text/html; charset=utf-8", livePageHtml};
  if (path == "/page.js") return ServerResponse{200, script, livePageScript};
  if (path == "/panel.js") return ServerResponse{200, script, livePanelScript};
  if (path == "/plan.js") return ServerResponse{200, script, livePlanScript};
  if (path == "/page.css")
    return ServerResponse{200, "text/css; charset=utf-8",
                          report::mapPageCss + report::worldPageCss + livePageCss};
  return std::nullopt;
}

}  // namespace

ServerResponse LiveSite::answer(const ServerRequest& request) {
  ServerResponse response = refused(404, "there is nothing here; /api/openapi.json says what there is");
  try {
    if (auto file = request.method == "GET" ? pageFile(request.path) : std::nullopt)
      response = std::move(*file);
    for (const Operation& operation : all()) {
      const std::optional<int> number = operation.match(request.path);
      if (!number) continue;
      if (operation.method == request.method) {
        response = operation.answer(*this, {request, *number});
        break;
      }
      response = refused(405, fmt::format("{} wants {}", operation.path, operation.method));
    }
  } catch (const Error& e) {
    response = failureResponse(statusFor(e.code()), nameOf(e.code()), e.what());
  } catch (const std::exception& e) {
    response = failureResponse(500, nameOf(ErrorCode::invalidState), e.what());
  }
  addSafety(response);
  const std::lock_guard lock(mutex_);
  if (access_ && isTokenInQuery(request, *access_))
    response.headers.emplace_back("Set-Cookie", fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/",
                                                            access_->cookieName(), access_->token));
  return response;
}

std::shared_ptr<const std::string> LiveSite::eventOf(const LiveStatus& status) {
  {
    const std::lock_guard lock(mutex_);
    if (event_ != nullptr && eventRevision_ == status.revision) return event_;
  }
  auto event = std::make_shared<const std::string>(
      fmt::format("id: {}\nevent: status\ndata: {}\n\n", status.revision, textOf(queries_.status(status))));
  const std::lock_guard lock(mutex_);
  eventRevision_ = status.revision;
  event_ = event;
  return event;
}

ServerResponse LiveSite::events(const ServerRequest& request) {
  using namespace std::chrono_literals;
  auto slot = std::make_shared<StreamSlot>(streams_);
  if (!slot->isFree()) return refused(503, "too many pages listen already; close one");
  struct Listener {
    std::shared_ptr<StreamSlot> slot;
    /// Revisions that the browser has seen.
    std::optional<std::uint64_t> seen;
    Clock::time_point sent = Clock::now();
    bool isNew = true;
  };
  auto listener = std::make_shared<Listener>(Listener{slot, std::nullopt});
  if (const std::string* last = request.findHeader("last-event-id")) {
    std::uint64_t revision = 0;
    const auto [end, problem] = std::from_chars(last->data(), last->data() + last->size(), revision);
    if (problem == std::errc{} && end == last->data() + last->size()) listener->seen = revision;
  }
  ServerResponse response{200, "text/event-stream"};
  response.events = [this, listener]() -> std::optional<std::string> {
    if (std::exchange(listener->isNew, false)) return "retry: 1000\n\n";
    const LiveStatus status = listener->seen ? view_.waitForChange(*listener->seen, 200ms) : view_.status();
    const auto since = Clock::now() - listener->sent;
    if (listener->seen == status.revision) {
      if (since < 10s) return "";
      listener->sent = Clock::now();
      return ": nothing new\n\n";
    }
    // Ten a second, and of those that come faster the newest.
    if (listener->seen && since < 100ms) {
      std::this_thread::sleep_for(100ms - since);
      return "";
    }
    listener->seen = status.revision;
    listener->sent = Clock::now();
    return *eventOf(status);
  };
  return response;
}

}  // namespace estancia
