// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/memory.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

#include "estancia/core/cgroup.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

/// The number after `key` in a file of lines "key number"; without a key the file's first word. Absent when
/// there is none ("max").
std::optional<std::uint64_t> numberIn(const fs::path& file, const std::string& key = "") {
  std::ifstream stream(file);
  std::uint64_t number = 0;
  for (std::string word; key.empty() || stream >> word;)
    if (key.empty() || word == key) return stream >> number ? std::optional(number) : std::nullopt;
  return std::nullopt;
}

/// Bytes that a limit leaves. Pages of files count as used but are given back when asked for.
std::uint64_t leftOf(const fs::path& group, const char* limitFile, const char* usageFile,
                     const char* cacheKey) {
  const auto limit = numberIn(group / limitFile), usage = numberIn(group / usageFile);
  if (!limit || !usage) return unlimited;
  const std::uint64_t cache = numberIn(group / "memory.stat", cacheKey).value_or(0);
  const std::uint64_t used = *usage - std::min(*usage, cache);
  return *limit - std::min(*limit, used);
}

}  // namespace

std::uint64_t availableMemory(const fs::path& root) {
  std::uint64_t available = unlimited;
  if (const auto kilobytes = numberIn(root / "proc/meminfo", "MemAvailable:")) available = *kilobytes * 1024;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {  // `ulimit -v`
    const std::uint64_t own = numberIn(root / "proc/self/status", "VmSize:").value_or(0) * 1024;
    available =
        std::min<std::uint64_t>(available, limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, own));
  }
  for (const fs::path& group : cgroupFolders(root, "memory")) {
    available = std::min(available, leftOf(group, "memory.max", "memory.current", "inactive_file"));  // v2
    available = std::min(available, leftOf(group, "memory.limit_in_bytes", "memory.usage_in_bytes",
                                           "total_inactive_file"));  // v1
  }
  return available;
}

}  // namespace estancia
