// Files fetched over HTTP: from several addresses, resumed where they broke off, kept only when they are
// right.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"

namespace estancia {

/// A file on the network, and what is known of it.
struct RemoteFile {
  std::vector<std::string> urls;  ///< http or https; the same file at several places, tried in order
  std::string sha256, sha1;       ///< hex digits, lower case; "" = not known. Those known must agree.
  std::uint64_t size = 0;         ///< bytes; 0 = not known
};

struct DownloadOptions {
  std::uint64_t most = 4ULL << 30U;  ///< bytes; a longer file is refused
  int connectSeconds = 20;           ///< until a server has answered the telephone
  int stallSeconds = 60;             ///< a server that gives less than 1 kB/s for so long counts as dead
  int pauseSeconds = 2;              ///< before a second try, and half as much again before a third
};

/// Fetches `file` to `target`, whose folder is made; does nothing when `target` is there already and is what
/// `file` says. Bytes that an earlier run left in TARGET.part are gone on with when they surely belong to the
/// same file: the server says so (If-Range), or the digest will tell. Follows redirects, but never from
/// https to http; a proxy is taken from the environment as curl does.
/// Throws Error naming each address's failure and what to do by hand; Interrupted on Ctrl-C. TARGET.part then
/// holds what has arrived, unless it was wrong.
void download(const RemoteFile& file, const std::filesystem::path& target, Progress& progress,
              const DownloadOptions& options = {});

/// How the file at `path` differs from what is known of it ("has SHA-256 … where … is expected"); "" when it
/// does not. Throws Error when it cannot be read.
std::string differenceFrom(const RemoteFile& file, const std::filesystem::path& path);

/// 12.3 MB
std::string megabytes(std::uint64_t bytes);

}  // namespace estancia
