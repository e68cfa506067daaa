// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/cores.hpp"

#include <sched.h>
#include <sys/times.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "estancia/core/cgroup.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

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

}  // namespace estancia
