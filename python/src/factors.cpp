#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "experiment/from_program.hpp"
#include "experiment/json_fields.hpp"
#include "rivid/experiment/factors_file.hpp"

namespace rivid::python {

namespace {

template <typename Factors>
nb::bytes bytes_of(const Factors& file) {
  const std::string content = [&] {
    const nb::gil_scoped_release unlocked;
    return encoded(file);
  }();
  return nb::bytes(content.data(), content.size());
}

// Their memory stays where it is: bytes never change.
std::string_view view(const nb::bytes& bytes) { return {bytes.c_str(), bytes.size()}; }

// Keys of [signal] with nothing left open, as JSON.
std::string chosen(const Robot& robot, const std::vector<const Log*>& logs, const std::string& sections,
                   const std::string& source) {
  const Experiment experiment = detail::experiment_from(robot, sections, source);
  std::vector<Log> copies;
  for (const Log* const log : logs) {
    copies.push_back(*log);
  }
  const SignalOptions signal = chosen_signal(robot, copies, detail::estimation_of(experiment));
  detail::Json out = {{"decimation", signal.decimation}, {"torque_held", signal.held()}};
  if (!signal.velocity_threshold.empty()) {
    out["velocity_threshold"] = signal.velocity_threshold;
  }
  return out.dump();
}

nb::bytes made(const Robot& robot, const std::vector<std::pair<const Log*, std::string>>& logs,
               const std::string& sections, const std::string& source, int blocks) {
  FactorsFile file;
  {
    const nb::gil_scoped_release unlocked;
    const Experiment experiment = detail::experiment_from(robot, sections, source);
    std::vector<Log> copies;
    std::vector<FactoredLog> names;
    for (const auto& [log, digest] : logs) {
      copies.push_back(*log);
      names.push_back({log->source, digest});
    }
    file = factors_of(experiment, copies, names, blocks);
  }
  return bytes_of(file);
}

nb::bytes merged(const std::vector<nb::bytes>& parts) {
  FactorsFile file;
  {
    const nb::gil_scoped_release unlocked;
    file = decoded_factors(view(parts.front()), "factors");
    for (std::size_t k = 1; k < parts.size(); ++k) {
      FactorsFile other = decoded_factors(view(parts[k]), "factors");
      const std::string source = other.logs.empty() ? "factors" : "factors of " + other.logs.front().path;
      merge(file, other, source);
    }
  }
  return bytes_of(file);
}

// What a request for loops comes to with some logs.
nb::bytes loops_of(const Robot& robot, const std::vector<const Log*>& logs, const std::string& sections,
                   const std::string& source, const nb::bytes& request, int blocks) {
  const std::string_view asked = view(request);
  LoopFactors found;
  {
    const nb::gil_scoped_release unlocked;
    const Estimation estimation = detail::estimation_of(detail::experiment_from(robot, sections, source));
    const LoopRequest wanted = decoded_loop_request(asked, source);
    for (const Log* const log : logs) {
      LoopFactors one = loop_factors(robot, *log, estimation, wanted, blocks);
      if (found.logs == 0) {
        found = std::move(one);
      } else {
        merge(found, one);
      }
    }
  }
  return bytes_of(found);
}

nb::bytes merged_loops(const std::vector<nb::bytes>& parts) {
  LoopFactors found;
  {
    const nb::gil_scoped_release unlocked;
    found = decoded_loop_factors(view(parts.front()), "loops");
    for (std::size_t k = 1; k < parts.size(); ++k) {
      merge(found, decoded_loop_factors(view(parts[k]), "loops"));
    }
  }
  return bytes_of(found);
}

// ask  for the loops of the logs, of instrumental variables; or None
std::pair<Identification, std::vector<std::pair<std::string, std::string>>> identified_from(
    const Robot& robot, const nb::bytes& content, const std::string& sections, const std::string& source,
    const nb::object& ask) {
  const std::string_view bytes = view(content);
  LoopAsk asked;
  if (!ask.is_none()) {
    asked = [&ask, &source](const LoopRequest& request) {
      const std::string text = encoded(request);
      const nb::gil_scoped_acquire locked;
      const auto answer = nb::cast<nb::bytes>(ask(nb::bytes(text.data(), text.size())));
      return decoded_loop_factors(view(answer), source);
    };
  }
  const nb::gil_scoped_release unlocked;
  const FactorsFile file = decoded_factors(bytes, "factors");
  std::vector<std::pair<std::string, std::string>> logs;
  for (const FactoredLog& log : file.logs) {
    logs.emplace_back(log.path, log.sha256);
  }
  return {identify_factors(detail::experiment_from(robot, sections, source), file, source, asked),
          std::move(logs)};
}

}  // namespace

void bind_factors(nb::module_& m) {
  m.def("chosen_signal", &chosen, "robot"_a, "logs"_a, "sections"_a, "source"_a, Unlocked(),
        "Keys of [signal] with nothing left open, as JSON.");
  m.def("factors", &made, "robot"_a, "logs"_a, "sections"_a, "source"_a, "blocks"_a,
        "Content of a .factors file of logs, each with its digest.");
  m.def("merged_factors", &merged, "parts"_a, "Contents of .factors files as one.");
  m.def("loop_factors", &loops_of, "robot"_a, "logs"_a, "sections"_a, "source"_a, "request"_a, "blocks"_a,
        "What a request for the closed loops of logs comes to.");
  m.def("merged_loop_factors", &merged_loops, "parts"_a, "What a request came to in several places.");
  m.def("identify_factors", &identified_from, "robot"_a, "content"_a, "sections"_a, "source"_a,
        "ask"_a.none(),
        "What the content of a .factors file says of a robot; path and digest of the logs. ask(request) "
        "carries out a request for their loops.");
}

}  // namespace rivid::python
