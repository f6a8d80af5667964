#include <algorithm>
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "report/document.hpp"

namespace rivid::detail {

namespace {

using ChartJson = nlohmann::ordered_json;

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t i) {
      return i < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) : 0U;
    };
    const std::uint32_t group = (byte(k) << 16U) | (byte(k + 1) << 8U) | byte(k + 2);
    out += digits[group >> 18U];
    out += digits[(group >> 12U) & 63U];
    out += k + 1 < bytes.size() ? digits[(group >> 6U) & 63U] : '=';
    out += k + 2 < bytes.size() ? digits[group & 63U] : '=';
  }
  return out;
}

template <typename Bits, typename Value>
std::string encoded_as(const Vector& values) {
  std::string bytes;
  for (const double value : values) {
    const auto bits = std::bit_cast<Bits>(static_cast<Value>(value));
    for (std::size_t k = 0; k < sizeof(Bits); ++k) {
      bytes += static_cast<char>((bits >> (8U * k)) & 0xffU);
    }
  }
  return base64(bytes);
}

// Low byte first, in base64.
std::string encoded(const Vector& values, bool exact) {
  return exact ? encoded_as<std::uint64_t, double>(values) : encoded_as<std::uint32_t, float>(values);
}

constexpr std::array<std::string_view, 4> kinds = {"line", "points", "band", "bars"};

// Series that share their abscissa have it once: the number of the series that has it stands in its place.
ChartJson series_data(const Chart& chart, std::size_t index) {
  const Series& series = chart.series[index];
  ChartJson out = {{"name", series.name},
                   {"style", series.style},
                   {"kind", kinds[static_cast<std::size_t>(series.kind)]},
                   {"exact", series.exact}};
  std::size_t same = 0;
  while (chart.series[same].x.size() != series.x.size() || chart.series[same].x != series.x) {
    ++same;
  }
  // Single precision of a clock that began long ago has no fractions of a second.
  constexpr double far = 4096.0;
  const bool fine = series.x.size() > 0 && series.x.cwiseAbs().maxCoeff() > far;
  out["fine"] = fine;
  out["x"] = same < index ? ChartJson(same) : ChartJson(encoded(series.x, fine));
  out["y"] = encoded(series.y, series.exact);
  if (series.upper.size() > 0) {
    out["upper"] = encoded(series.upper, series.exact);
  }
  if (series.on_demand) {
    out["on_demand"] = true;
  }
  return out;
}

void add_data(const Chart& chart, ChartJson& out) {
  ChartJson series = ChartJson::array();
  for (std::size_t k = 0; k < chart.series.size(); ++k) {
    series.push_back(series_data(chart, k));
  }
  ChartJson rules = ChartJson::array();
  for (const Rule& rule : chart.rules) {
    rules.push_back({{"upright", rule.upright}, {"at", rule.at}, {"style", rule.style}});
  }
  out[chart.id] = {
      {"x", chart.x_label},     {"y", chart.y_label},          {"logarithmic", chart.logarithmic},
      {"height", chart.height}, {"series", std::move(series)}, {"rules", std::move(rules)}};
}

void add_data(const HeatMap& map, ChartJson& out) {
  const Matrix rows = map.values.transpose();
  out[map.id] = {{"names", map.names}, {"values", encoded(rows.reshaped(), false)}};
}

void add_data(const Skeleton& skeleton, ChartJson& out) {
  const auto list = [](const auto& values) { return std::vector<double>(values.begin(), values.end()); };
  ChartJson joints = ChartJson::array();
  for (const Eigen::Vector3d& joint : skeleton.joints) {
    joints.push_back(list(joint));
  }
  ChartJson bodies = ChartJson::array();
  for (const Skeleton::Ellipsoid& body : skeleton.ellipsoids) {
    bodies.push_back({{"name", body.name},
                      {"style", body.style},
                      {"mass", body.mass},
                      {"centre", list(body.centre)},
                      {"axes", list(body.axes.reshaped())}});
  }
  ChartJson traces = ChartJson::array();
  for (const Skeleton::Trace& trace : skeleton.traces) {
    ChartJson points = ChartJson::array();
    for (const Eigen::Vector3d& point : trace.points) {
      points.push_back(list(point));
    }
    traces.push_back({{"name", trace.name}, {"style", trace.style}, {"points", std::move(points)}});
  }
  out[skeleton.id] = {
      {"joints", std::move(joints)}, {"bodies", std::move(bodies)}, {"traces", std::move(traces)}};
}

void add_data(const DotPlot& plot, ChartJson& out) {
  ChartJson rows = {{"", plot.x_label, "from", "to"}};
  for (const auto& [name, interval, mark] : plot.dots) {
    rows.push_back({name, interval.value, interval.low, interval.high});
  }
  out[plot.id] = {{"rows", std::move(rows)}};
}

// A picture alone says all.
void add_data(const PathPlot& /*plot*/, ChartJson& /*out*/) {}

template <typename Take>
void for_each_plot(const std::vector<Block>& blocks, const Take& take) {
  for (const Block& block : blocks) {
    if (const auto* const plots = std::get_if<Plots>(&block.content)) {
      for (const Plots::Group& group : plots->groups) {
        std::ranges::for_each(group.plots, take);
      }
    }
  }
}

template <typename Take>
void for_each_plot(const Document& document, const Take& take) {
  for_each_plot(document.first_look, take);
  for (const Section& section : document.sections) {
    for_each_plot(section.blocks, take);
  }
}

}  // namespace

bool has_time(const Document& document) {
  bool out = false;
  for_each_plot(document, [&](const Plot& plot) {
    const auto* const chart = std::get_if<Chart>(&plot);
    out = out || (chart != nullptr && chart->log);
  });
  return out;
}

std::string data_of(const Document& document) {
  ChartJson out = ChartJson::object();
  for_each_plot(document,
                [&](const Plot& plot) { std::visit([&](const auto& each) { add_data(each, out); }, plot); });
  // Nothing in it may end the <script>.
  std::string text = out.dump(-1, ' ', false, ChartJson::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

}  // namespace rivid::detail
