// SPDX-License-Identifier: Apache-2.0
// CPU cores and memory that this process may use, as cores.hpp and memory.hpp declare them.
#include <sched.h>
#include <sys/resource.h>
#include <sys/times.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "estancia/core/cores.hpp"
#include "estancia/core/memory.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// Folders of the control groups of this process, of version 2 and of version 1's `controller` ("cpu",
/// "memory"): its own first, then the enclosing ones. `root` is where /proc and /sys are, for tests.
std::vector<fs::path> cgroupFolders(const fs::path& root, std::string_view controller) {
  std::vector<fs::path> folders;
  const fs::path mount = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");  // lines ID:CONTROLLERS:PATH
  for (std::string line; std::getline(groups, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const bool version2 = controllers == ",,";
    if (!version2 && controllers.find("," + std::string(controller) + ",") == std::string::npos) continue;
    const fs::path top = version2 ? mount : mount / controller;
    fs::path at = top / fs::path(line.substr(second + 1)).relative_path();
    for (;; at = at.parent_path()) {
      folders.push_back(at);
      if (at == top || !at.has_relative_path()) break;
    }
  }
  return folders;
}

std::string textOf(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The CPUs of this process' affinity mask; empty if unknown.
std::set<int> allowedCpus() {
  std::set<int> cpus;
  cpu_set_t mask;
  CPU_ZERO(&mask);
  if (sched_getaffinity(0, sizeof mask, &mask) != 0) return cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(cpu, &mask)) cpus.insert(cpu);
  return cpus;
}

/// Cores that "quota period" stands for; `maxCores` when there is no limit.
double quotaOf(const std::string& limits, double maxCores) {
  std::istringstream text(limits);
  double quota = 0, period = 0;
  return text >> quota >> period && quota > 0 && period > 0 ? std::min(maxCores, quota / period) : maxCores;
}

/// The tightest limit of the cgroups around this process.
double cgroupQuota(const fs::path& root, double maxCores) {
  for (const fs::path& group : cgroupFolders(root, "cpu")) {
    maxCores = quotaOf(textOf(group / "cpu.max"), maxCores);  // v2
    maxCores =
        quotaOf(textOf(group / "cpu.cfs_quota_us") + textOf(group / "cpu.cfs_period_us"), maxCores);  // v1
  }
  return maxCores;
}

/// CPU time of this process [clock ticks].
long long ownTicks() {
  tms own{};
  times(&own);
  return own.tms_utime + own.tms_stime;
}

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

/// The number after `key` in a file of lines "key number", or the first word; absent without one ("max").
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

int usableCores(const fs::path& root) {
  const std::size_t allowed = allowedCpus().size();
  const double cores = allowed > 0 ? static_cast<double>(allowed) : std::thread::hardware_concurrency();
  return std::max(1, static_cast<int>(cgroupQuota(root, cores)));
}

long long busyTicks(const std::string& procStat, const std::set<int>& cpus) {
  std::istringstream lines(procStat);
  std::set<int> missing = cpus;
  long long busy = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("cpu") || line.size() < 4 || line[3] == ' ') continue;
    std::istringstream numbers(line.substr(3));
    int cpu = -1;
    long long user = 0, nice = 0, system = 0, idle = 0, wait = 0, irq = 0, softIrq = 0, stolen = 0;
    if (!(numbers >> cpu >> user >> nice >> system >> idle >> wait >> irq >> softIrq >> stolen)) continue;
    if (missing.erase(cpu) > 0) busy += user + nice + system + irq + softIrq + stolen;
  }
  return missing.empty() ? busy : -1;
}

int freeCores() {
  const int usable = usableCores();
  const std::set<int> cpus = allowedCpus();
  if (usable == 1 || cpus.empty()) return usable;
  constexpr std::chrono::milliseconds window(50);
  const std::string before = textOf("/proc/stat");
  const long long ownBefore = ownTicks();
  std::this_thread::sleep_for(window);
  const std::string after = textOf("/proc/stat");
  const long long ours = ownTicks() - ownBefore;
  const long long allBefore = busyTicks(before, cpus), allAfter = busyTicks(after, cpus);
  if (allBefore < 0 || allAfter < 0) return usable;
  const double ticks =
      static_cast<double>(sysconf(_SC_CLK_TCK)) * std::chrono::duration<double>(window).count();
  const double busy = std::max(0.0, static_cast<double>(allAfter - allBefore - ours)) / ticks;
  const double idle = static_cast<double>(cpus.size()) - busy;
  return std::clamp(static_cast<int>(std::lround(idle)), 1, usable);
}

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
