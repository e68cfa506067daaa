// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/ascii.hpp"
#include "estancia/fetch/download.hpp"
#include "fuzz/answering_server.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(fetch, archive) {
  extractMember(inputFile("input.archive", bytes), "labels.txt", folder() / "labels.txt", 1 << 20);
}

/// What a server answers, the part that is there already, and its version.
FUZZ_TARGET(fetch, http_answer) {
  static AnsweringServer server;
  const auto texts = parts(bytes, 3);
  // The target does not wait half a minute for a retry, and contacts no other machine.
  for (const char* header : {"retry-after", "location"})
    if (lowerCase(std::string(texts[0])).find(header) != std::string::npos) return;
  const std::filesystem::path file = folder() / "fetched";
  for (const char* ending : {"", ".part", ".part.from"}) std::filesystem::remove(file.string() + ending);
  if (!texts[1].empty()) inputFile("fetched.part", texts[1]);
  const std::string url = server.url() + "/file";
  inputFile("fetched.part.from", url + "\n" + std::string(texts[2]));
  server.answerWith(texts[0]);
  RemoteFile remote;
  remote.urls = {url};
  remote.size = texts[2].empty() ? 0 : 12;
  download(remote, file, {.maxBytes = 1 << 20, .connectSeconds = 5, .stallSeconds = 5, .pauseSeconds = 0});
}

}  // namespace estancia::fuzz
