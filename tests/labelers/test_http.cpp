// Web services as labelers: real servers on loopback, well and badly behaved.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <httplib.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <nlohmann/json.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "estancia/core/progress.hpp"
#include "estancia/labelers/model.hpp"
#include "support/errors.hpp"
#include "support/loopback.hpp"
#include "support/model_support.hpp"

namespace estancia {
namespace {

using test::FailsWith;
using test::writeFile;
using testing::ElementsAre;
using Clock = std::chrono::steady_clock;

cv::Mat gray(int value = 128) {
  return {32, 48, CV_8UC3, cv::Scalar::all(value)};
}

/// Which gray() a posted JPEG is.
int valueOf(const httplib::Request& request) {
  const std::vector<unsigned char> bytes(request.body.begin(), request.body.end());
  return static_cast<int>(cv::mean(cv::imdecode(bytes, cv::IMREAD_COLOR))[0] + 0.5);
}

void answer(httplib::Response& response, const std::string& json, int status = 200) {
  response.status = status;
  response.set_content(json, "application/json");
}

/// A certificate that signs itself, for one name.
struct Certificate {
  explicit Certificate(const char* subject) {
    key = EVP_EC_gen("P-256");
    certificate = X509_new();
    ASN1_INTEGER_set(X509_get_serialNumber(certificate), 1);
    X509_gmtime_adj(X509_getm_notBefore(certificate), -60);
    X509_gmtime_adj(X509_getm_notAfter(certificate), 3600);
    X509_set_version(certificate, X509_VERSION_3);
    X509_set_pubkey(certificate, key);
    X509_NAME* name = X509_get_subject_name(certificate);
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("test"), -1,
                               -1, 0);
    X509_set_issuer_name(certificate, name);
    X509_EXTENSION* names = X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, subject);
    X509_add_ext(certificate, names, -1);
    X509_EXTENSION_free(names);
    X509_sign(certificate, key, EVP_sha256());
  }
  ~Certificate() {
    X509_free(certificate);
    EVP_PKEY_free(key);
  }
  Certificate(const Certificate&) = delete;
  Certificate& operator=(const Certificate&) = delete;
  std::string pem() const {
    BIO* memory = BIO_new(BIO_s_mem());
    PEM_write_bio_X509(memory, certificate);
    char* text = nullptr;
    const auto size = static_cast<std::size_t>(BIO_get_mem_data(memory, &text));
    std::string result(text, size);
    BIO_free(memory);
    return result;
  }
  EVP_PKEY* key;
  X509* certificate;
};

/// Serves `handle` at /label until it goes.
class Service {
 public:
  explicit Service(std::unique_ptr<httplib::Server> server = std::make_unique<httplib::Server>())
      : server_(std::move(server)) {
    server_->new_task_queue = [] { return new httplib::ThreadPool(8); };
    server_->set_keep_alive_timeout(1);
    server_->Post("/label", [this](const httplib::Request& request, httplib::Response& response) {
      ++requests;
      handle(request, response);
    });
    port = server_->bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_->listen_after_bind(); });
    while (!server_->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Service() {
    server_->stop();
    thread_.join();
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  httplib::Server::Handler handle = [](const auto&, auto& response) {
    answer(response, R"({"labels": {"cup": 0.75, "mug": 0.25}})");
  };
  std::atomic<int> requests{0};
  int port = 0;

 private:
  std::unique_ptr<httplib::Server> server_;
  std::thread thread_;
};

/// Accepts connections, and does with each what `behave` does until the end or false.
class RawServer {
 public:
  explicit RawServer(std::function<bool(int)> behave) : behave_(std::move(behave)) {
    const test::Listener listener = test::listenOnLoopback();
    socket_ = listener.socket;
    port = listener.port;
    thread_ = std::thread([this] { run(); });
  }
  ~RawServer() {
    ending_ = true;
    ::shutdown(socket_, SHUT_RDWR);
    thread_.join();
    ::close(socket_);
  }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;
  int port = 0;

 private:
  void run() {
    while (!ending_) {
      const int connection = ::accept(socket_, nullptr, nullptr);
      if (connection < 0) continue;
      while (!ending_ && behave_(connection)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      ::close(connection);
    }
  }
  std::function<bool(int)> behave_;
  std::atomic<bool> ending_{false};
  int socket_ = -1;
  std::thread thread_;
};

bool say(int connection, const std::string& text) {
  return ::send(connection, text.data(), text.size(), MSG_NOSIGNAL) > 0;
}

class HttpLabeler : public testing::Test {
 protected:
  std::unique_ptr<Labeler> openAt(const std::string& url, const std::string& more = "") {
    writeFile(scratch_ / "model.toml",
              "name = \"web\"\ntype = \"http\"\nurl = \"" + url + "\"\n" + more + "\n" +
                  (more.find("backoff") == std::string::npos ? "backoff = 0.001\n" : ""));
    return loadModel(scratch_.path().string());
  }
  std::unique_ptr<Labeler> openPort(int port, const std::string& more = "") {
    return openAt("http://127.0.0.1:" + std::to_string(port) + "/label", more);
  }
  std::unique_ptr<Labeler> open(const std::string& more = "") { return openPort(service_.port, more); }
  test::Caught refusal(const std::string& more = "") {
    return test::caught([&] { open(more)->label(gray(), "0007.png"); });
  }
  void answerAlways(const std::string& json, int status = 200) {
    service_.handle = [=](const auto&, auto& response) { answer(response, json, status); };
  }
  static std::vector<LabelResult> labelAll(Labeler& labeler, const std::vector<int>& values) {
    std::vector<Prepared> batch;
    for (const int value : values) batch.push_back(labeler.prepare(gray(value), std::to_string(value)));
    return labeler.inferBatch(batch);
  }
  Service service_;
  test::ScratchFolder scratch_;
};

/// The service of the thesis, in the form it has now.
TEST_F(HttpLabeler, SpeaksWithClarifai) {
  setenv("ESTANCIA_TEST_KEY", "s3cr3t", 1);
  service_.handle = [](const auto& request, auto& response) {
    EXPECT_EQ(request.get_header_value("Authorization"), "Key s3cr3t");
    EXPECT_EQ(request.get_header_value("Content-Type"), "application/json");
    const nlohmann::json body = nlohmann::json::parse(request.body);
    const std::string image = body["inputs"][0]["data"]["image"]["base64"];
    EXPECT_EQ(image.substr(0, 4), "/9j/") << "a JPEG";
    answer(response, R"({"status": {"code": 10000}, "outputs": [{"data": {"concepts": [
        {"id": "a", "name": "table", "value": 0.99}, {"id": "b", "name": "room", "value": 0.5},
        {"id": "c", "name": "window", "value": 0.7}]}}]})");
  };
  const auto labeler = open(R"(body = '{"inputs":[{"data":{"image":{"base64":"${image}"}}}]}'
labels_at = "/outputs/0/data/concepts"
label_key = "name"
confidence_key = "value"
best = 2
headers = { Authorization = "Key ${ESTANCIA_TEST_KEY}" })");
  EXPECT_THAT(labeler->label(gray()), ElementsAre(0.99F, 0.7F));
  EXPECT_THAT(labeler->vocabulary().labels(), ElementsAre("table", "window"));
}

TEST_F(HttpLabeler, NeverShowsASecret) {
  setenv("ESTANCIA_TEST_KEY", "s3cr3t", 1);
  const std::string headers = "headers = { Authorization = \"Key ${ESTANCIA_TEST_KEY}\" }";
  const auto gives = [&](int status, const std::string& json) {
    answerAlways(json, status);
    const std::string message = refusal(headers + "\nattempts = 1").message;
    EXPECT_EQ(message.find("s3cr3t"), std::string::npos) << status;
    EXPECT_NE(message.find("***"), std::string::npos) << status;
  };
  for (const int status : {200, 400, 401, 418, 500}) gives(status, R"(no "s3cr3t")");
  gives(200, R"({"error": "bad key s3cr3t"})");
  gives(200, R"({"labels": {"s3cr3t": 7}})");
  const std::string identity = open(headers)->identity();
  EXPECT_EQ(identity.find("s3cr3t"), std::string::npos);
  setenv("ESTANCIA_TEST_KEY", "other", 1);
  EXPECT_EQ(open(headers)->identity(), identity) << "another key is the same model";
  EXPECT_NE(open(headers + "\nbest = 5")->identity(), identity);
  setenv("ESTANCIA_TEST_KEY", "a\r\nX-Injected: b", 1);
  EXPECT_THAT(refusal(headers), FailsWith(ErrorCode::malformedFile));
  EXPECT_EQ(refusal(headers).message.find("Injected"), std::string::npos);
  unsetenv("ESTANCIA_TEST_KEY");
  EXPECT_THAT(refusal(headers), FailsWith(ErrorCode::malformedFile));
}

TEST_F(HttpLabeler, WorksOnSeveralAtATimeButDiscoversInTheFramesOrder) {
  std::mutex mutex;
  std::condition_variable changed;
  int arrived = 0, answered = 0;
  service_.handle = [&](const auto& request, auto& response) {
    const int value = valueOf(request);
    std::unique_lock lock(mutex);
    ++arrived;
    changed.notify_all();
    const auto patience = std::chrono::seconds(60);
    EXPECT_TRUE(changed.wait_for(lock, patience, [&] { return arrived == 4; })) << "all four in flight";
    // The first frame is answered last.
    const int rank = 3 - value / 50;
    EXPECT_TRUE(changed.wait_for(lock, patience, [&] { return answered == rank; }));
    ++answered;
    changed.notify_all();
    answer(response, "{\"labels\": {\"common\": 0.25, \"w" + std::to_string(value / 50) + "\": 0.5}}");
  };
  const auto labeler = open();
  const auto results = labelAll(*labeler, {0, 50, 100, 150});
  EXPECT_THAT(labeler->vocabulary().labels(), ElementsAre("w0", "common", "w1", "w2", "w3"));
  EXPECT_THAT(results[0].descriptor, ElementsAre(0.5F, 0.25F));
  EXPECT_THAT(results[2].descriptor, ElementsAre(0, 0.25F, 0, 0.5F));
}

TEST_F(HttpLabeler, TriesAgainWhatMayPass) {
  for (const int status : {500, 503, 429, 408}) {
    service_.requests = 0;
    service_.handle = [&, status](const auto&, auto& response) {
      if (service_.requests < 3)
        answer(response, "busy", status);
      else
        answer(response, R"({"labels": {"cup": 1}})");
    };
    EXPECT_THAT(open()->label(gray()), ElementsAre(1)) << status;
    EXPECT_EQ(service_.requests, 3);
  }
  service_.requests = 0;
  answerAlways("out of order", 500);
  EXPECT_THAT(refusal("attempts = 3"), FailsWith(ErrorCode::serverFailure));
  EXPECT_EQ(service_.requests, 3);
}

TEST_F(HttpLabeler, WaitsAsLongAsItIsToldButNotForever) {
  std::vector<Clock::time_point> times;
  service_.handle = [&](const auto&, auto& response) {
    times.push_back(Clock::now());
    response.set_header("Retry-After", "1");
    answer(response, R"({"labels": {"cup": 1}})", times.size() == 1 ? 429 : 200);
  };
  EXPECT_THAT(open()->label(gray()), ElementsAre(1));
  EXPECT_GE(times.at(1) - times.at(0), std::chrono::milliseconds(900));
  for (const std::string wait : {"3600", "Wed, 21 Oct 2099 07:28:00 GMT"}) {
    service_.handle = [&](const auto&, auto& response) {
      response.set_header("Retry-After", wait);
      answer(response, "slow down", 429);
    };
    EXPECT_THAT(refusal("max_wait = 2"), FailsWith(ErrorCode::serverFailure));
  }
  EXPECT_EQ(service_.requests, 4);
}

TEST_F(HttpLabeler, AnImageThatIsRefusedIsOneFrameLess) {
  for (const int status : {400, 413, 415, 422}) {
    service_.handle = [status](const auto& request, auto& response) {
      if (valueOf(request) < 100)
        answer(response, "too dark", status);
      else
        answer(response, R"({"labels": {"cup": 1}})");
    };
    const auto labeler = open();
    const auto results = labelAll(*labeler, {20, 200});
    EXPECT_NE(results[0].problem, "") << status;
    EXPECT_EQ(results[1].problem, "");
    EXPECT_THAT(results[1].descriptor, ElementsAre(1));
    EXPECT_THROW(labeler->label(gray(20)), FrameError);
  }
}

TEST_F(HttpLabeler, EndsWhereTryingIsVain) {
  for (const int status : {401, 402, 403, 404}) {
    answerAlways("no", status);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::serverFailure)) << status;
  }
  EXPECT_EQ(service_.requests, 4) << "each was tried once";
  service_.handle = [](const auto&, auto& response) { response.set_redirect("http://elsewhere/label", 307); };
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::serverFailure));
  EXPECT_EQ(service_.requests, 5);
}

TEST_F(HttpLabeler, KeepsWhatWasAnsweredBesideAFailure) {
  service_.handle = [](const auto& request, auto& response) {
    if (valueOf(request) == 100)
      answer(response, "no", 403);
    else
      answer(response, R"({"labels": {"cup": 1}})");
  };
  const auto labeler = open("parallel = 1\nattempts = 100\nbackoff = 60");
  try {
    labelAll(*labeler, {0, 50, 100, 150});
    FAIL() << "a refused key must end the work";
  } catch (const BatchError& e) {
    EXPECT_EQ(e.code(), ErrorCode::serverFailure);
    ASSERT_EQ(e.results.size(), 4U);
    EXPECT_FALSE(e.results[0].descriptor.empty());
    EXPECT_FALSE(e.results[1].descriptor.empty());
    EXPECT_TRUE(e.results[2].descriptor.empty() && e.results[2].problem.empty());
    EXPECT_TRUE(e.results[3].descriptor.empty()) << "not asked any more";
  }
}

TEST_F(HttpLabeler, RefusesNonsense) {
  for (const std::string json :
       {"<html>Hello</html>", "", R"({"labels": {"cup": 87}})", R"({"labels": {"cup": -1}})",
        R"({"labels": {"cup": NaN}})", R"({"concepts": {}})"}) {
    answerAlways(json);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << json;
  }
  answerAlways("{\"labels\": \"" + std::string(5'000'000, 'x') + "\"}");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::network));
  answerAlways(R"({"labels": {}})");
  EXPECT_THROW(open()->label(gray()), FrameError) << "no word is known at all";
}

TEST_F(HttpLabeler, OutlastsASlowLoris) {
  const std::string settings = "timeout = 0.2\nread_timeout = 60\nattempts = 1";
  for (const std::string start :
       {"HTTP/1.1 200 ", "HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n"}) {
    bool begun = false;
    const RawServer dribbling([&](int c) {
      const bool sent = say(c, std::exchange(begun, true) ? "x" : start);
      begun = begun && sent;
      return sent;
    });
    EXPECT_THAT([&] { openPort(dribbling.port, settings)->label(gray()); }, FailsWith(ErrorCode::network));
  }
  const RawServer handshake([](int c) { return say(c, std::string("\x16\x03\x03\x3f\xff", 5)); });
  const std::string tls = "https://127.0.0.1:" + std::to_string(handshake.port) + "/";
  EXPECT_THAT([&] { openAt(tls, settings)->label(gray()); }, FailsWith(ErrorCode::network));
}

/// Before curl's pull request 11103 a handle that is used again writes the line into freed memory, as the
/// address sanitizer sees.
TEST_F(HttpLabeler, KeepsItsConnectionAndRefusesAnAnswerThatBeginsWithAFoldedLine) {
  std::atomic<int> connections{0};
  std::atomic<bool> folds{false};
  int last = -1;
  const RawServer server([&](int c) {
    if (std::exchange(last, c) != c) ++connections;
    const std::string json = R"({"labels": {"mug": 0.75}})";
    const std::string request = test::hearRequest(c);
    EXPECT_EQ(request.find("\r\nX-Empty:\r\n") != std::string::npos, !request.empty()) << request;
    return !request.empty() &&
           say(c, std::string("HTTP/1.1 200 OK\r\n") + (folds ? " folded\r\n" : "") +
                      "Content-Length: " + std::to_string(json.size()) + "\r\n\r\n" + json);
  });
  const auto labeler = openPort(server.port, "attempts = 1\nheaders = {X-Empty = \"\"}");
  for (int i = 0; i < 5; ++i) EXPECT_THAT(labeler->label(gray()), ElementsAre(0.75F));
  EXPECT_EQ(connections, 1);
  folds = true;
  EXPECT_THAT([&] { labeler->label(gray()); }, FailsWith(ErrorCode::network));
}

TEST_F(HttpLabeler, RefusesEndlessHeaders) {
  std::string lines = "HTTP/1.1 200 OK\r\n";
  for (int i = 0; i < 10'000; ++i) lines += "X-More: " + std::string(100, 'x') + "\r\n";
  const std::string status = "HTTP/1.1 200 " + std::string(3'000'000, 'x') + "\r\n\r\n{}";
  for (const std::string& endless : {lines, status}) {
    const RawServer server([&](int c) { return say(c, endless) && endless == lines; });
    EXPECT_THAT([&] { openPort(server.port)->label(gray()); }, FailsWith(ErrorCode::network));
  }
}

TEST_F(HttpLabeler, StopsWhenTheUserWantsTo) {
  const RawServer silent([](int) { return true; });
  const auto labeler = openPort(silent.port, "attempts = 1");
  const Prepared batch[] = {labeler->prepare(gray()), labeler->prepare(gray())};
  const auto label = [&] {
    catchInterrupts();
    std::thread user([] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      kill(getpid(), SIGINT);
    });
    try {
      labeler->inferBatch(batch);
    } catch (const Interrupted&) {
      user.join();
      std::_Exit(7);
    }
    std::_Exit(1);
  };
  EXPECT_EXIT(label(), testing::ExitedWithCode(7), "");
}

TEST_F(HttpLabeler, GivesUpOnSilenceNoHttpAndBrokenConnections) {
  const RawServer silent([](int) { return true; });
  EXPECT_THAT([&] { openPort(silent.port, "read_timeout = 0.05\nattempts = 2")->label(gray()); },
              FailsWith(ErrorCode::network));
  const RawServer foreign([](int c) { return say(c, "H"); });
  EXPECT_THAT([&] { openPort(foreign.port, "attempts = 2")->label(gray()); }, FailsWith(ErrorCode::network));
  const RawServer closing([](int c) {
    say(c, "HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\n{\"labels\"");
    return false;
  });
  EXPECT_THAT([&] { openPort(closing.port, "attempts = 2")->label(gray()); }, FailsWith(ErrorCode::network));
  int port = 0;
  {
    const RawServer gone([](int) { return false; });
    port = gone.port;
  }
  EXPECT_THAT([&] { openPort(port, "attempts = 2")->label(gray()); }, FailsWith(ErrorCode::network));
}

TEST_F(HttpLabeler, KeepsToItsRate) {
  const auto labeler = open("rate = 20");
  const auto start = Clock::now();
  labelAll(*labeler, {0, 50, 100, 150, 200});
  EXPECT_GE(Clock::now() - start, std::chrono::milliseconds(195)) << "four gaps of 1/20 s";
}

TEST_F(HttpLabeler, ChecksCertificates) {
  const Certificate own("IP:127.0.0.1"), foreign("DNS:elsewhere.example");
  writeFile(scratch_ / "own.pem", own.pem());
  writeFile(scratch_ / "foreign.pem", foreign.pem());
  writeFile(scratch_ / "broken.pem", "no certificate");
  const Service honest(std::make_unique<httplib::SSLServer>(own.certificate, own.key));
  const Service impostor(std::make_unique<httplib::SSLServer>(foreign.certificate, foreign.key));
  const auto openTls = [&](const Service& service, const std::string& more) {
    return openAt("https://127.0.0.1:" + std::to_string(service.port) + "/label", more);
  };
  const auto refusalOf = [&](const Service& service, const std::string& more) {
    return test::caught([&] { openTls(service, more)->label(gray()); });
  };
  EXPECT_THAT(openTls(honest, "ca = \"own.pem\"")->label(gray()), ElementsAre(0.75F, 0.25F));
  EXPECT_THAT(refusalOf(honest, ""), FailsWith(ErrorCode::network)) << "signs itself";
  EXPECT_THAT(refusalOf(impostor, "ca = \"own.pem\""), FailsWith(ErrorCode::network));
  EXPECT_THAT(refusalOf(impostor, "ca = \"foreign.pem\""), FailsWith(ErrorCode::network));
  EXPECT_THAT(refusalOf(honest, "ca = \"broken.pem\""), FailsWith(ErrorCode::network));
  EXPECT_THAT(refusalOf(honest, "ca = \"none.pem\""), FailsWith(ErrorCode::fileNotFound));
  EXPECT_EQ(impostor.requests, 0);
}

TEST_F(HttpLabeler, SendsTheImageAloneOrInAFormInTheFormatAskedFor) {
  for (const std::string format : {"jpg", "png"})
    for (const bool form : {false, true}) {
      const std::string type = format == "jpg" ? "image/jpeg" : "image/png";
      service_.handle = [&](const httplib::Request& request, auto& response) {
        const auto file = request.get_file_value("photo");
        EXPECT_EQ(file.filename, form ? "image." + format : "");
        EXPECT_EQ(form ? file.content_type : request.get_header_value("Content-Type"), type);
        const std::string& bytes = form ? file.content : request.body;
        const std::vector<unsigned char> image(bytes.begin(), bytes.end());
        EXPECT_EQ(cv::mean(cv::imdecode(image, cv::IMREAD_COLOR))[0], 128);
        answer(response, R"({"labels": {"cup": 1}})");
      };
      const auto labeler = open("format = \"" + format + "\"\n" + (form ? "field = \"photo\"" : ""));
      EXPECT_THAT(labeler->label(gray()), ElementsAre(1)) << type;
      const std::vector<LabelProbability> remembered{{"mug", 0.5F}};
      EXPECT_THAT(labeler->adopt(remembered), ElementsAre(0, 0.5F)) << "known from a cache";
    }
}

TEST_F(HttpLabeler, ChecksItsSettings) {
  const std::pair<std::string, ErrorCode> lines[] = {
      {"methd = 1", ErrorCode::malformedFile},
      {"field = \"a\"\nbody = \"${image}\"", ErrorCode::malformedFile},
      {"body = \"{}\"", ErrorCode::malformedFile},
      {"headers = { \"A: b\" = \"c\" }", ErrorCode::malformedFile},
      {"headers = { \"\" = \"c\" }", ErrorCode::malformedFile},
      {"headers = { A = \"${HOME\" }", ErrorCode::malformedFile},
      {"field = \"\"", ErrorCode::malformedFile},
      {"field = 'a\"b'", ErrorCode::malformedFile},
      {"field = \"a\\nb\"", ErrorCode::malformedFile},
      {"format = \"gif\"", ErrorCode::malformedFile},
      {"parallel = 0", ErrorCode::malformedFile},
      {"labels_at = \"outputs\"", ErrorCode::invalidOption}};
  for (const auto& line : lines) EXPECT_THAT([&] { open(line.first); }, FailsWith(line.second)) << line.first;
  for (const std::string url :
       {"", "127.0.0.1/label", "ftp://a/b", "http://", "http://user:key@host/", "http://a b/"})
    EXPECT_THAT([&] { openAt(url); }, FailsWith(ErrorCode::malformedFile)) << url;
  const std::string server = "http://127.0.0.1:" + std::to_string(service_.port);
  EXPECT_THAT([&] { openAt(server + "?to=label")->label(gray()); }, FailsWith(ErrorCode::serverFailure));
}

}  // namespace
}  // namespace estancia
