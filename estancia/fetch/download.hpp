// Download: a file over HTTP from several addresses, resumed, verified; and one file out of an archive.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "estancia/core/progress.hpp"

namespace estancia {

class OptionGroup;

/// A file on the network, and what is known of it.
struct RemoteFile {
  /// http or https; the same file at several places, tried in order.
  std::vector<std::string> urls;
  /// Hex digits, lower case; "" = not known.
  std::string sha256;
  /// [bytes]; 0 = not known.
  std::uint64_t size = 0;
};

struct DownloadOptions {
  /// A longer file is refused [bytes].
  std::uint64_t maxBytes = 4ULL << 30U;
  /// Until a connection stands.
  int connectSeconds = 20;
  /// A server that gives less than 1 kB/s for so long counts as dead.
  int stallSeconds = 60;
  /// Before a second try; twice as long before a third.
  int pauseSeconds = 2;
};

OptionGroup declare(DownloadOptions& options);

/// Fetches `file` to `target`, whose folder is made; does nothing when `target` is there already and matches
/// `file`. Bytes that an earlier run left in TARGET.part are gone on with when they surely belong to the same
/// file: the server confirms it (If-Range), or the digest will verify it. Follows redirects, but never from
/// https to http; a proxy is taken from the environment as curl does. Throws Error naming each address's
/// failure and what to do by hand; Interrupted. TARGET.part then holds what has arrived, unless it was wrong.
void download(const RemoteFile& file, const std::filesystem::path& target,
              const DownloadOptions& options = {}, Progress& progress = Progress::none());

/// How the file at `path` differs from what is known of it ("has SHA-256 … where … is expected"); "" when it
/// does not. Throws Error when it cannot be read.
std::string differenceFrom(const RemoteFile& file, const std::filesystem::path& path);

/// 12.3 MB
std::string megabytes(std::uint64_t bytes);

/// Writes the member `name` of `archive`, a zip, or a tar plain or compressed by gzip, bzip2, xz or zstd, to
/// `target`, whole or not at all. `name` is the member's path, or only its last part; nothing else of the
/// archive is looked at, so that none of its paths can do harm.
/// Returns false when there is no such file in it. Throws Error when the archive is damaged or no archive,
/// when the member is longer than `maxBytes`, and when `target` cannot be written.
bool extractMember(const std::filesystem::path& archive, const std::string& name,
                   const std::filesystem::path& target, std::uint64_t maxBytes);

}  // namespace estancia
