#include "experiment/byte_parts.hpp"
#include "rivid/experiment/factors_file.hpp"

namespace rivid {

namespace {

using detail::Json;

constexpr std::string_view request_magic = "rivid-LQ";
constexpr std::string_view loops_magic = "rivid-LL";
constexpr std::uint32_t loops_version = 1;  // of the format

Json json_of_matrix(const Matrix& x) {
  return {{"rows", x.rows()}, {"values", std::vector<double>(x.data(), x.data() + x.size())}};
}

Matrix matrix_at(const detail::PartReader& reader, const char* key) {
  const Json& from = reader.description().at(key);
  const auto values = from.at("values").get<std::vector<double>>();
  const auto rows = from.at("rows").get<Index>();
  const auto count = std::ssize(values);
  if (rows < 0 || (rows == 0 ? count != 0 : count % rows != 0)) {
    throw reader.fault(std::string("is damaged: ") + key + " is no matrix");
  }
  return Eigen::Map<const Matrix>(values.data(), rows, rows == 0 ? 0 : count / rows);
}

// Keys and members of what a description holds beside words and counts.
template <typename Factors, typename Visit>
void for_each_vector(Factors& of, const Visit& visit) {
  visit("mean_speeds", of.mean_speeds);
  visit("mean_squares", of.mean_squares);
  visit("J", of.J);
  visit("tracking", of.sums.tracking);
  visit("missed", of.sums.missed);
  visit("control", of.sums.control);
  visit("moving", of.sums.moving);
}

template <typename Factors, typename Visit>
void for_each_matrix(Factors& of, const Visit& visit) {
  visit("off_measured", of.sums.off_measured);
  visit("measured", of.sums.measured);
  visit("off_reference", of.sums.off_reference);
  visit("reference", of.sums.reference);
}

template <typename Effort, typename Visit>
void for_each_count(Effort& of, const Visit& visit) {
  visit("steps", of.steps);
  visit("right_hand_sides", of.right_hand_sides);
  visit("restarts", of.restarts);
  visit("mode_changes", of.mode_changes);
  visit("seconds", of.seconds);
}

Json description_of_loops(const LoopFactors& factors) {
  Json columns = Json::array();
  for (const InstrumentalGroup& group : factors.groups) {
    columns.push_back(group.columns);
  }
  Json out = {{"logs", factors.logs},
              {"failure", factors.failure},
              {"gave_up", factors.gave_up},
              {"simulated_signs", factors.simulated_signs},
              {"samples", factors.sums.samples},
              {"columns", columns},
              {"used", !factors.used.empty()},
              {"blocks", factors.blocks.size()}};
  const auto put = [&](const char* key, const auto& value) { out[key] = json_of_matrix(value); };
  for_each_vector(factors, put);
  for_each_matrix(factors, put);
  for_each_count(factors.effort, [&](const char* key, const auto& value) { out[key] = value; });
  return out;
}

LoopFactors described_loops(const detail::PartReader& reader) {
  const Json& from = reader.description();
  LoopFactors out;
  out.logs = from.at("logs").get<Index>();
  out.failure = from.at("failure").get<std::string>();
  out.gave_up = from.at("gave_up").get<bool>();
  out.simulated_signs = from.at("simulated_signs").get<bool>();
  out.sums.samples = from.at("samples").get<double>();
  for_each_vector(out, [&](const char* key, Vector& value) { value = matrix_at(reader, key).reshaped(); });
  for_each_matrix(out, [&](const char* key, Matrix& value) { value = matrix_at(reader, key); });
  for_each_count(out.effort, [&](const char* key, auto& value) { from.at(key).get_to(value); });
  return out;
}

}  // namespace

std::string encoded(const LoopRequest& request) {
  return detail::PartWriter(request_magic, loops_version,
                            {{"pass", static_cast<int>(request.pass)},
                             {"chi_st", json_of_matrix(request.chi_st)},
                             {"J", json_of_matrix(request.J)},
                             {"simulated_signs", request.simulated_signs},
                             {"steps_before", request.steps_before}})
      .content();
}

LoopRequest decoded_loop_request(std::string_view content, std::string_view source) {
  const detail::PartReader reader(content, request_magic, loops_version, "holds no request for loops",
                                  source);
  try {
    reader.expect_end();
    const Json& from = reader.description();
    const int pass = from.at("pass").get<int>();
    if (pass < static_cast<int>(LoopPass::speeds) || pass > static_cast<int>(LoopPass::rows)) {
      throw reader.fault("is damaged: there is no pass " + std::to_string(pass));
    }
    return {.pass = static_cast<LoopPass>(pass),
            .chi_st = matrix_at(reader, "chi_st").reshaped(),
            .J = matrix_at(reader, "J").reshaped(),
            .simulated_signs = from.at("simulated_signs").get<bool>(),
            .steps_before = from.at("steps_before").get<Index>()};
  } catch (const Json::exception& e) {
    throw reader.fault(std::string("is damaged: ") + e.what());
  }
}

std::string encoded(const LoopFactors& factors) {
  detail::PartWriter out(loops_magic, loops_version, description_of_loops(factors));
  out.put(factors.groups);
  out.put(factors.used);
  for (const std::vector<InstrumentalGroup>& block : factors.blocks) {
    out.put(block);
  }
  return std::move(out).content();
}

LoopFactors decoded_loop_factors(std::string_view content, std::string_view source) {
  detail::PartReader reader(content, loops_magic, loops_version, "holds no factors of loops", source);
  try {
    const Json& description = reader.description();
    LoopFactors out = described_loops(reader);
    const auto columns = reader.columns();
    const auto instrumental = [&] {
      return reader.groups<InstrumentalGroup>(columns, [](Index own) { return own + 1; });
    };
    out.groups = instrumental();
    if (description.at("used").get<bool>()) {
      out.used = reader.groups<RowGroup>(columns, [](Index /*own*/) { return Index{1}; });
    }
    for (Index g = reader.count("blocks", LogFactors::most_blocks); g > 0; --g) {
      out.blocks.push_back(instrumental());
    }
    reader.expect_end();
    return out;
  } catch (const Json::exception& e) {
    throw reader.fault(std::string("is damaged: ") + e.what());
  }
}

}  // namespace rivid
