#include "odd/run.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <iostream>
#include <sstream>
#include <thread>

#include "rivid/error.hpp"

namespace rivid::odd {

std::vector<const Kind*> kinds_of(const std::string& names) {
  std::vector<const Kind*> out;
  std::istringstream in(names);
  for (std::string name; std::getline(in, name, ',');) {
    const std::size_t before = out.size();
    for (const Kind& kind : kinds()) {
      if (kind.name == name || kind.group == name ||
          (name == "all" && kind.group != "no_rotor" && kind.group != "laws")) {
        out.push_back(&kind);
      }
    }
    if (out.size() == before) {
      std::string known;
      for (const Kind& kind : kinds()) {
        known += ' ' + std::string(kind.name);
      }
      throw InputError("no kind or group is called \"" + name + "\"; kinds are" + known);
    }
  }
  return out;
}

std::vector<const Way*> ways_of(const std::string& names) {
  std::vector<const Way*> out;
  std::istringstream in(names);
  for (std::string name; std::getline(in, name, ',');) {
    const std::size_t before = out.size();
    for (const Way& way : ways()) {
      if (way.name == name || name == "all") {
        out.push_back(&way);
      }
    }
    if (out.size() == before) {
      throw InputError("no way is called \"" + name + "\"; see benchmarks/odd/kinds.cpp");
    }
  }
  return out;
}

void run_series(const Series& series, const Asked& asked, RecordFile& file, bool loud) {
  std::vector<std::pair<Name, Asked>> work;
  for (std::uint64_t i = 0; i < series.count; ++i) {
    const std::uint64_t pair = i / series.ways.size();
    const Name name{series.seed, series.kinds[pair % series.kinds.size()],
                    series.first + pair / series.kinds.size(), series.ways[i % series.ways.size()]};
    Asked missing = asked;
    std::erase_if(missing.methods, [&](const std::string& method) { return file.has(name, method); });
    if (!missing.methods.empty()) {
      work.emplace_back(name, std::move(missing));
    }
  }
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> done = 0;
  std::exception_ptr failure;
  std::mutex failing;
  const auto labour = [&] {
    try {
      for (std::size_t i = next++; i < work.size(); i = next++) {
        file.append(carried_out(work[i].first, work[i].second));
        const std::size_t finished = ++done;
        if (loud && (finished % 100 == 0 || finished == work.size())) {
          std::cerr << finished << " of " << work.size() << '\n';
        }
      }
    } catch (...) {
      const std::lock_guard lock(failing);
      failure = std::current_exception();
      next = work.size();
    }
  };
  {
    std::vector<std::jthread> team;
    for (int k = 0; k < series.threads; ++k) {
      team.emplace_back(labour);
    }
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace rivid::odd
