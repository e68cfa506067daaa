// SPDX-License-Identifier: Apache-2.0
#include "estancia/site/live_site.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

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
  using enum ErrorCode;
  if (code == invalidInput || code == invalidOption) return 400;
  if (code == unknownName || code == noAnswer || code == fileNotFound) return 404;
  return code == busy || code == insufficientData || code == invalidState || code == mismatch ? 409 : 500;
}

std::string_view codeFor(int status) {
  return status == 401   ? "unauthorized"
         : status == 403 ? "forbidden"
         : status == 405 ? "method-not-allowed"
         : status == 415 ? "wrong-type"
         : status == 503 ? "too-many"
                         : "not-found";
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
            "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
            "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
           {"X-Content-Type-Options", "nosniff"},
           {"X-Frame-Options", "DENY"},
           {"Referrer-Policy", "no-referrer"},
           {"Cross-Origin-Resource-Policy", "same-origin"},
           {"Cache-Control", "no-store"}})
    response.headers.emplace_back(name, value);
}

/// Who listens to a stream of events, and the stream's place among LiveSite::maxStreams.
struct Listener {
  explicit Listener(std::shared_ptr<std::atomic<int>> streams) : count(std::move(streams)) {}
  ~Listener() { count->fetch_sub(1); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::shared_ptr<std::atomic<int>> count;
  bool isAdmitted = count->fetch_add(1) < LiveSite::maxStreams;
  std::optional<std::uint64_t> seen;  // revisions that the browser has seen
  Clock::time_point sent = Clock::now();
  bool isNew = true;
};

}  // namespace

/// A request of the API, whose parameters must be known and fit.
struct LiveSite::Question {
  const ServerRequest& request;
  /// Number in the path: "{node}".
  int number = 0;

  void requireKnown(const std::vector<std::string_view>& known) const {
    for (const auto& [name, value] : request.query) {
      if (name == "token") continue;
      if (std::ranges::find(known, name) == known.end())
        fail(ErrorCode::invalidInput, "there is no parameter \"{}\" here{}", printable(name),
             known.empty() ? "" : fmt::format("; there are {}", fmt::join(known, ", ")));
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
    const auto value = wholeNumber<int>(text(name));
    if (!value || *value < least || *value > most)
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
  using Answer = ServerResponse(LiveSite& site, const Question& question);
  std::string method, path;
  std::vector<std::string_view> parameters;
  Answer* answer;

  /// The number in the path; -1 where it has none, nothing where it is another path.
  std::optional<int> match(std::string_view asked) const {
    const std::size_t open = path.find('{');
    if (open == std::string::npos) return asked == path ? std::optional(-1) : std::nullopt;
    const std::string_view before = std::string_view(path).substr(0, open),
                           after = std::string_view(path).substr(path.find('}') + 1);
    if (asked.size() <= before.size() + after.size() || !asked.starts_with(before) || !asked.ends_with(after))
      return std::nullopt;
    asked = asked.substr(before.size(), asked.size() - before.size() - after.size());
    const auto number = wholeNumber<int>(asked);
    return number && *number >= 0 ? number : std::nullopt;
  }
};

std::vector<LiveSite::Operation> LiveSite::makeOperations() {
  using Site = LiveSite&;
  using Asked = const Question&;
  constexpr int anyNumber = std::numeric_limits<int>::max();
  std::vector<Operation> all;
  const auto get = [&all](const char* path, std::vector<std::string_view> parameters,
                          Operation::Answer* answer) {
    all.push_back({"GET", path, std::move(parameters), answer});
  };
  get("/api/status", {}, [](Site site, Asked) { return jsonResponse(site.queries_.status()); });
  get("/api/where", {}, [](Site site, Asked) { return jsonResponse(site.queries_.where()); });
  get("/api/ask", {"words", "max"}, [](Site site, Asked asked) {
    const int most = asked.numberOf("max", 1, 100).value_or(10);
    return jsonResponse(site.queries_.ask(asked.text("words"), static_cast<std::size_t>(most)));
  });
  get("/api/route", {"to", "from", "avoid", "prefer"}, [](Site site, Asked asked) {
    return jsonResponse(site.queries_.route({asked.text("to"), asked.numberOf("from", 0, anyNumber),
                                             asked.texts("avoid"), asked.texts("prefer")}));
  });
  get("/api/objects", {}, [](Site site, Asked) { return jsonResponse(site.queries_.objects()); });
  get("/api/areas", {}, [](Site site, Asked) { return jsonResponse(site.queries_.areas()); });
  get("/api/changes", {"since"}, [](Site site, Asked asked) {
    return jsonResponse(site.queries_.changes(asked.numberOf("since", 1, anyNumber)));
  });
  get("/api/map", {}, [](Site site, Asked) {
    return ServerResponse{200, "application/json", *site.queries_.map()};
  });
  get("/api/places/{node}", {},
      [](Site site, Asked asked) { return jsonResponse(site.queries_.place(asked.number)); });
  // A new name for each frame keeps browsers from showing an old one.
  get("/api/frame.jpg", {"revision"}, [](Site site, Asked) {
    const auto image = site.view_.image();
    return imageResponse(image == nullptr ? std::vector<unsigned char>() : *image);
  });
  get("/api/objects/{object}.jpg", {},
      [](Site site, Asked asked) { return imageResponse(site.view_.objectImage(asked.number)); });
  get("/api/places/{node}.jpg", {},
      [](Site site, Asked asked) { return imageResponse(site.view_.placeImage(asked.number)); });
  get("/api/events", {}, [](Site site, Asked asked) { return site.events(asked.request); });
  get("/api/openapi.json", {}, [](Site, Asked) { return ServerResponse{200, "application/json", openApi}; });
  all.push_back({"POST", "/api/edits", {"map_revision"}, [](Site site, Asked asked) {
                   site.view_.edit(parseEdit(asked.request.body),
                                   asked.numberOf("map_revision", 0, anyNumber));
                   return jsonResponse({{"map_revision", site.view_.status().mapRevision}});
                 }});
  return all;
}

const std::vector<LiveSite::Operation>& LiveSite::all() {
  static const std::vector<Operation> operations = makeOperations();
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
  const auto access = [this] {
    const std::lock_guard lock(mutex_);
    return access_;
  }();
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
        const Question question{request, *number};
        question.requireKnown(operation.parameters);
        response = operation.answer(*this, question);
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
  auto listener = std::make_shared<Listener>(streams_);
  if (!listener->isAdmitted) return refused(503, "too many pages listen already; close one");
  if (const std::string* last = request.findHeader("last-event-id"))
    listener->seen = wholeNumber<std::uint64_t>(*last);
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
