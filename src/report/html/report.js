// What the page draws, and what a reader can do with it: zoom along time, read values, take numbers and pictures along, turn the
// robot, sort tables. #data holds what each figure shows by its id; this is the only program that draws it.
(() => {
  "use strict";
  const root = document.documentElement;
  const data = JSON.parse(document.getElementById("data").textContent);
  const figures = [...document.querySelectorAll("figure")].filter((figure) => data[figure.id]);
  const charts = figures.filter((figure) => data[figure.id].series);
  const over_time = charts.filter((figure) => figure.dataset.log !== undefined);
  const place_of = (figure) => figure.querySelector(".picture");
  const is_wide = (figure) => figure.classList.contains("wide");

  // ------------------------------------------------------------------ numbers

  function decoded(text, double) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return double ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer);
  }

  // The series of a chart with their numbers, decoded once.
  function series_of(id) {
    const chart = data[id];
    if (!chart.decoded) {
      chart.decoded = [];
      for (const s of chart.series) {
        chart.decoded.push({
          ...s,
          x: typeof s.x === "number" ? chart.decoded[s.x].x : decoded(s.x, s.fine),
          y: decoded(s.y, s.exact),
          upper: s.upper ? decoded(s.upper, s.exact) : null,
          hidden: s.on_demand === true,
        });
      }
    }
    return chart.decoded;
  }
  const values_of = (id) => (data[id].decoded ??= decoded(data[id].values, false));

  const digits = (value, count) =>
    value === null || value === undefined || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(count)));

  // ------------------------------------------------------------------ scales

  // About so many round numbers, 1, 2 or 5 times a power of ten apart. The first is `low` or below, the last `high` or above.
  function round_ticks(low, high, count) {
    const wanted = (high - low) / count;
    const decade = 10 ** Math.floor(Math.log10(wanted));
    const lead = wanted / decade;
    const step = decade * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
    const rounding = 1e-9; // a multiple that is missed by rounding alone counts as met
    const first = Math.floor(low / step + rounding);
    const last = Math.ceil(high / step - rounding);
    return Array.from({ length: last - first + 1 }, (_, k) => (first + k) * step);
  }

  // The least and the largest number of some lists; `positive` are logarithms alone.
  function range_of(lists, positive = false) {
    let [low, high] = [Infinity, -Infinity];
    for (const list of lists) {
      for (const value of list ?? []) {
        if (Number.isFinite(value) && !(positive && value <= 0)) {
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
    }
    return low <= high ? [low, high] : positive ? [1, 10] : [0, 1];
  }

  // Values along the pixels from … to. The ends are those of the range, or the ticks around them where they are `rounded`.
  function scale_of([low, high], [from, to], { rounded = false, logarithmic = false, count = 5 } = {}) {
    const most_decades = 8; // more of them hide everything else
    let ticks;
    if (logarithmic) {
      high = Math.ceil(Math.log10(high));
      low = Math.min(Math.max(Math.floor(Math.log10(low)), high - most_decades), high - 1);
      ticks = Array.from({ length: high - low + 1 }, (_, k) => 10 ** (low + k));
    } else {
      const room = high > low ? 0 : Math.max(0.1 * Math.abs(low), 1e-3);
      [low, high] = [low - room, high + room];
      ticks = round_ticks(low, high, count);
      [low, high] = rounded ? [ticks[0], ticks[ticks.length - 1]] : [low, high];
      const rounding = 1e-9 * (high - low);
      ticks = ticks.filter((t) => t >= low - rounding && t <= high + rounding).map((t) => (Math.abs(t) < rounding ? 0 : t));
    }
    const measure = (value) => (logarithmic ? Math.log10(Math.max(value, 10 ** low)) : value);
    return {
      low,
      high,
      ticks,
      at: (value) => from + ((measure(value) - low) / (high - low)) * (to - from),
      value: (pixel) => low + ((pixel - from) / (to - from)) * (high - low),
    };
  }

  // ------------------------------------------------------------------ pictures

  const page_width = 1120; // of plots in a fold that is closed
  const panel_width = 360;
  const under_plot = 38; // ticks and label of the abscissa
  const digit_width = 6.5;

  const escaped = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const tenths = (value) => value.toFixed(1);
  const pair = ([x, y]) => tenths(x) + " " + tenths(y);
  const line = (style, [x1, y1], [x2, y2]) =>
    `<line class="${style}" x1="${tenths(x1)}" y1="${tenths(y1)}" x2="${tenths(x2)}" y2="${tenths(y2)}"/>`;
  const dot = (style, [x, y], r) => `<circle class="${style}" cx="${tenths(x)}" cy="${tenths(y)}" r="${r}"/>`;
  const path = (style, d, more = "") => `<path class="${style}" d="${d}"${more}/>`;
  const polyline = (style, points) => `<polyline class="${style}" points="${points.map((p) => p.map(tenths).join(",")).join(" ")}"/>`;
  const words = (anchor, [x, y], text) => `<text text-anchor="${anchor}" x="${tenths(x)}" y="${tenths(y)}">${escaped(text)}</text>`;
  const turned = (anchor, at, angle, text) =>
    `<text text-anchor="${anchor}" transform="translate(${pair(at)}) rotate(${angle})">${escaped(text)}</text>`;
  function box(style, [x1, y1], [x2, y2]) {
    const [left, top] = [Math.min(x1, x2), Math.min(y1, y2)];
    return `<rect class="${style}" x="${tenths(left)}" y="${tenths(top)}" width="${tenths(Math.abs(x2 - x1))}" height="${tenths(Math.abs(y2 - y1))}"/>`;
  }
  const picture = (width, height, label, content) =>
    `<svg role="img" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"><title>${escaped(label)}</title>${content}</svg>`;

  // Grid, ticks and label; a tick without room has no number.
  function abscissa(x, label, frame) {
    let out = "";
    let last = -Infinity;
    for (const tick of x.ticks) {
      const at = x.at(tick);
      const text = digits(tick, 6);
      out += line("grid", [at, frame.top], [at, frame.bottom]);
      if (at - last >= digit_width * text.length + 6) {
        out += words("middle", [at, frame.bottom + 15], text);
        last = at;
      }
    }
    return out + words("middle", [0.5 * (frame.left + frame.right), frame.bottom + 32], label);
  }
  function ordinate(y, label, frame) {
    let out = turned("middle", [11, 0.5 * (frame.top + frame.bottom)], -90, label);
    for (const tick of y.ticks) {
      out += line(tick === 0 ? "grid origin" : "grid", [frame.left, y.at(tick)], [frame.right, y.at(tick)]);
      out += words("end", [frame.left - 5, y.at(tick) + 4], digits(tick, 6));
    }
    return out;
  }

  // ------------------------------------------------------------------ charts

  // Lifts the pen at gaps; of many points in one column of pixels it has the lowest and the highest.
  function curve(s, x, y) {
    const column = ([across]) => Math.floor(across / 2);
    let d = "";
    let piece = [];
    const lift = () => {
      d += piece.length > 0 ? "M" + piece.map(pair).join("L") + (piece.length === 1 ? "h.1" : "") : "";
      piece = [];
    };
    for (const k of s.part) {
      if (!Number.isFinite(s.y[k])) {
        lift();
        continue;
      }
      const at = [x.at(s.x[k]), y.at(s.y[k])];
      const [first, second] = piece.slice(-2);
      if (second && column(first) === column(at) && column(second) === column(at)) {
        const heights = [first[1], second[1], at[1]];
        const ends = [Math.min(...heights), Math.max(...heights)];
        [first[1], second[1]] = first[1] > second[1] ? ends.reverse() : ends;
      } else {
        piece.push(at);
      }
    }
    lift();
    return path("curve " + s.style, d);
  }
  function points(s, x, y) {
    const shown = s.part.filter((k) => Number.isFinite(s.y[k]));
    return path("cloud " + s.style, shown.map((k) => "M" + pair([x.at(s.x[k]), y.at(s.y[k])]) + "h0").join(""));
  }
  function band(s, x, y) {
    let d = "";
    let piece = [];
    for (const k of [...s.part, -1]) {
      if (k >= 0 && Number.isFinite(s.y[k])) {
        piece.push(k);
      } else if (piece.length > 0) {
        const side = (values) => piece.map((i) => pair([x.at(s.x[i]), y.at(values[i])]));
        d += "M" + [...side(s.y), ...side(s.upper).reverse()].join("L") + "Z";
        piece = [];
      }
    }
    return path("area " + s.style, d);
  }
  function bars(s, x, y) {
    const half = Math.max(0.45 * Math.abs(x.at(s.x[1] ?? s.x[0] + 1) - x.at(s.x[0])), 0.5);
    const bar = (k) => box("bar " + s.style, [x.at(s.x[k]) - half, y.at(0)], [x.at(s.x[k]) + half, y.at(s.y[k])]);
    return s.part.filter((k) => Number.isFinite(s.y[k])).map(bar).join("");
  }
  const drawn_as = { line: curve, points, band, bars };

  const ranges = {}; // of the time that is shown of each log

  function draw_chart(figure) {
    const chart = data[figure.id];
    const { log } = figure.dataset;
    const all = series_of(figure.id);
    const width = is_wide(figure) ? place_of(figure).clientWidth || page_width : panel_width;
    const { min, max } = ranges[log] ?? { min: -Infinity, max: Infinity };
    for (const s of all) {
      // One row more to either side, to which the curve goes on.
      const inside = (k) => s.x[k] >= min && s.x[k] <= max;
      s.part = [...s.x.keys()].filter((k) => inside(k) || inside(k - 1) || inside(k + 1));
    }
    const shown = all.filter((s) => !s.hidden);
    const heights = shown.flatMap((s) => [s.part.map((k) => s.y[k]), s.upper && s.part.map((k) => s.upper[k])]);
    const bottom = chart.height - under_plot;
    const { logarithmic } = chart;
    const count = Math.min(bottom / 35, 5);
    const y = scale_of(range_of([...heights, chart.y_shown], logarithmic), [bottom, 6], { rounded: true, logarithmic, count });
    // Plots over time stand below each other, with their ticks.
    const longest = Math.max(log === undefined ? 1 : 6, ...y.ticks.map((tick) => digits(tick, 6).length));
    const frame = { left: 26 + digit_width * longest, top: 6, right: width - 10, bottom };
    const span = ranges[log] ? [min, max] : range_of([...all.map((s) => s.x), chart.x_shown]);
    const x = scale_of(span, [frame.left, frame.right], { count: Math.max(width / 110, 5) });
    let content = shown.map((s) => drawn_as[s.kind](s, x, y)).join("");
    for (const { upright, at, style } of chart.rules) {
      content += upright
        ? line("rule " + style, [x.at(at), frame.top], [x.at(at), frame.bottom])
        : line("rule " + style, [frame.left, y.at(at)], [frame.right, y.at(at)]);
    }
    if (log !== undefined) {
      const size = [frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top];
      const place = `x="${size[0]}" y="${size[1]}" width="${size[2]}" height="${size[3]}"`;
      content = `<svg ${place} viewBox="${size.join(" ")}">${content}<rect class="selection"/><line class="cursor"/></svg>`;
    }
    content = abscissa(x, chart.x, frame) + ordinate(y, chart.y, frame) + content;
    place_of(figure).innerHTML = picture(width, chart.height, chart.label, content);
    figure.plot = { x, y, frame, width, series: all };
  }

  // What each curve is; a click hides it or shows it.
  function add_legend(figure) {
    const all = series_of(figure.id);
    if (all.length < 2) {
      return;
    }
    const legend = document.createElement("p");
    legend.className = "legend";
    for (const s of all.filter((each) => !each.unnamed)) {
      const item = button("", "Show or hide " + s.name, () => {
        s.hidden = !s.hidden;
        item.setAttribute("aria-pressed", !s.hidden);
        draw_chart(figure);
      });
      const key = document.createElement("span");
      key.className = `key ${s.kind === "line" ? "" : s.kind === "points" ? "dot" : "area"} ${s.style}`;
      item.className = "item";
      item.setAttribute("aria-pressed", !s.hidden);
      item.append(key, s.name);
      legend.append(item);
    }
    place_of(figure).before(legend);
  }

  // ------------------------------------------------------------------ other plots

  function draw_map(figure) {
    const { names, label } = data[figure.id];
    const values = values_of(figure.id);
    const [left, top] = [62, 26];
    const cell = Math.min(Math.max(620 / names.length, 8), 30);
    const across = (j) => left + cell * j;
    const down = (i) => top + cell * i;
    const levels = 10;
    let content = "";
    names.forEach((name, i) => {
      for (let j = 0; j < i; ++j) {
        const r = values[i * names.length + j];
        const level = Math.round(Math.min(Math.abs(r), 1) * levels);
        if (level > 0) {
          const square = `M${pair([across(j), down(i)])}h${tenths(cell - 0.6)}v${tenths(cell - 0.6)}h-${tenths(cell - 0.6)}z`;
          content += path(r < 0 ? "against" : "together", square, ` opacity="${level / levels}"`);
        }
      }
      content += words("end", [left - 4, down(i) + 0.5 * cell + 4], name);
      content += turned("start", [across(i) + 0.5 * cell + 3, down(i) + cell - 1], -50, name);
    });
    const size = cell * names.length;
    place_of(figure).innerHTML = picture(left + size + 40, top + size + 4, label, content);
    figure.cell_at = ([x, y]) => [Math.floor((y - top) / cell), Math.floor((x - left) / cell)];
  }

  function draw_dots(figure) {
    const { rows, off, reference, wanted, label } = data[figure.id];
    const [[, x_label], ...dots] = rows;
    const row = 17;
    const frame = { left: 58, top: 8, right: panel_width - 12, bottom: 12 + row * dots.length };
    const ends = dots.flatMap(([, value, low, high]) => (Number.isFinite(value) ? [low, high] : []));
    const x = scale_of(range_of([ends, [reference]]), [frame.left, frame.right], { rounded: true });
    const place = (value) => Math.min(Math.max(x.at(value), frame.left), frame.right);
    let content = abscissa(x, x_label, frame);
    content += box("band", [place(wanted[0]), frame.top], [place(wanted[1]), frame.bottom]);
    content += line("reference", [place(reference), frame.top], [place(reference), frame.bottom]);
    dots.forEach(([name, value, low, high], i) => {
      const y = frame.top + row * (i + 0.5) + 2;
      const style = off[i] ? " off" : "";
      content += words("end", [frame.left - 6, y + 4], name);
      if (Number.isFinite(value)) {
        content += line("whisker" + style, [x.at(low), y], [x.at(high), y]) + dot("dot" + style, [x.at(value), y], 3.2);
      }
    });
    place_of(figure).innerHTML = picture(panel_width, frame.bottom + under_plot, label, content);
  }

  const margin = 6; // of the smallest pictures

  function draw_path(figure) {
    const { steps, interval, label } = data[figure.id];
    const [width, height] = [170, 64];
    const x = scale_of([0, Math.max(steps.length - 1, 1)], [margin, width - margin]);
    const y = scale_of(range_of([steps, interval]), [height - margin, margin]);
    let content = "";
    if (interval) {
      const top = y.at(interval[1]);
      content = box("band", [0, top], [width, Math.max(y.at(interval[0]), top + 1)]);
    }
    const points = steps.flatMap((value, k) => (Number.isFinite(value) ? [[x.at(k), y.at(value)]] : []));
    content += polyline("path", points) + points.map((at) => dot("value", at, 2)).join("");
    place_of(figure).innerHTML = picture(width, height, label, content);
  }

  // An interval on an axis of its own, with a value in it and one to compare it with, in a cell of a table.
  for (const cell of document.querySelectorAll(".interval-bar")) {
    const [low, high, value, reference] = cell.dataset.values.split(" ").map(parseFloat);
    const [width, height] = [140, 18];
    const middle = 0.5 * height;
    // Shares of the value: zero at the left, twice the value at the right; what is farther ends there.
    const end = (share) => margin + 0.5 * Math.min(Math.max(share, 0), 2) * (width - 2 * margin);
    const x = { at: (v) => end(v / value) };
    const upright = (style, at, from) => line(style, [at, from], [at, height - from]);
    const zero = x.at(0);
    cell.innerHTML = picture(
      width,
      height,
      cell.dataset.label,
      line("axis", [0, middle], [width, middle]) +
        (zero >= 0 && zero <= width ? upright("zero", zero, 1) : "") +
        (Number.isFinite(reference) ? upright("apriori", x.at(reference), 3) : "") +
        line("interval", [x.at(low), middle], [x.at(high), middle]) +
        dot("value", [x.at(value), middle], 2.6),
    );
  }

  // ------------------------------------------------------------------ the robot

  function draw_bodies(figure) {
    const shown = data[figure.id];
    const { joints, bodies, traces, label } = shown;
    const [width, height] = [620, 440];
    const places = [...joints, ...traces.flatMap((t) => t.points)];
    const middle = [0, 1, 2].map((c) => {
      const [low, high] = range_of([places.map((p) => p[c])]);
      return 0.5 * (low + high);
    });
    const from_middle = (p) => p.map((value, c) => value - middle[c]);
    const axes_of = (body) => [0, 3, 6].map((a) => body.axes.slice(a, a + 3));
    const longest = (body) => Math.max(...axes_of(body).map((axis) => Math.hypot(...axis)));
    const far = Math.max(
      ...places.map((p) => Math.hypot(...from_middle(p))),
      ...bodies.map((b) => Math.hypot(...from_middle(b.centre)) + longest(b)),
    );
    const pixels = (0.5 * Math.min(width, height) - 10) / far;
    shown.yaw ??= -0.9;
    shown.pitch ??= 0.42;
    const right = [Math.cos(shown.yaw), Math.sin(shown.yaw), 0];
    const down = [Math.sin(shown.pitch) * right[1], -Math.sin(shown.pitch) * right[0], -Math.cos(shown.pitch)];
    const product = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const at = (p) => {
      const v = from_middle(p);
      return [0.5 * width + pixels * product(right, v), 0.5 * height + pixels * product(down, v)];
    };
    let content = traces.map((t) => polyline("trace " + t.style, t.points.map(at))).join("");
    for (const body of bodies) {
      // The outline of the projected ellipsoid: eigenvalues of (P A)(P A)ᵀ.
      let [xx, xy, yy] = [0, 0, 0];
      for (const axis of axes_of(body)) {
        const [x, y] = [product(right, axis), product(down, axis)];
        xx += x * x;
        xy += x * y;
        yy += y * y;
      }
      const mean = 0.5 * (xx + yy);
      const apart = Math.hypot(0.5 * (xx - yy), xy);
      const angle = (0.5 * Math.atan2(2 * xy, xx - yy) * 180) / Math.PI;
      const radii = [mean + apart, mean - apart].map((square) => tenths(pixels * Math.sqrt(Math.max(square, 0))));
      content +=
        `<ellipse class="${body.style}" rx="${radii[0]}" ry="${radii[1]}" transform="translate(${pair(at(body.centre))}) rotate(${tenths(angle)})">` +
        `<title>${escaped(body.name)}</title></ellipse>`;
    }
    const line_of_joints = (shown.poses[shown.pose]?.joints ?? joints).map(at);
    content += polyline("arm", line_of_joints) + line_of_joints.map((p) => dot("joint", p, 3)).join("");
    place_of(figure).innerHTML = picture(width, height, label, content);
  }

  function turn_by_hand(figure) {
    const shown = data[figure.id];
    function turn(across, up) {
      shown.yaw += across;
      shown.pitch = Math.max(-1.55, Math.min(1.55, shown.pitch + up));
      draw_bodies(figure);
    }
    const place = place_of(figure);
    place.tabIndex = 0;
    place.setAttribute("role", "group");
    place.setAttribute("aria-label", "The robot; arrow keys turn it");
    const steps = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    place.addEventListener("keydown", (event) => {
      if (steps[event.key]) {
        event.preventDefault();
        turn(...steps[event.key]);
      }
    });
    place.addEventListener("pointerdown", (event) => place.setPointerCapture(event.pointerId));
    place.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) {
        turn(-0.01 * event.movementX, 0.01 * event.movementY);
      }
    });
  }

  // The robot at an instant of its motion, by a slider, or moving as fast as it will.
  function add_player(figure) {
    const shown = data[figure.id];
    const last = shown.poses.length - 1;
    const duration = shown.poses[last].t;
    const slider = Object.assign(document.createElement("input"), { type: "range", min: 0, max: last, value: 0 });
    const words = document.createElement("span");
    let begun;
    function show(k) {
      shown.pose = k;
      slider.value = k;
      words.textContent = shown.poses[k].t.toFixed(2) + " s";
      draw_bodies(figure);
    }
    function step(now) {
      if (begun !== undefined) {
        show(Math.round(((((now - begun) / 1000) % duration) / duration) * last));
        requestAnimationFrame(step);
      }
    }
    function set_moving(moving) {
      begun = moving ? performance.now() - 1000 * shown.poses[shown.pose].t : undefined;
      play.textContent = moving ? "❚❚" : "▶";
      requestAnimationFrame(step);
    }
    const play = button("▶", "Move the robot", () => set_moving(begun === undefined));
    play.setAttribute("aria-label", "Move the robot");
    slider.setAttribute("aria-label", "Instant of the motion");
    slider.addEventListener("input", () => {
      set_moving(false);
      show(Number(slider.value));
    });
    const player = document.createElement("div");
    player.className = "player";
    player.append(play, slider, words);
    figure.append(player);
    show(0);
  }

  // ------------------------------------------------------------------ numbers and pictures to take along

  const quoted = (text) => (/[",\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text);
  const csv = (rows) => rows.map((row) => row.map((cell) => quoted(String(cell ?? ""))).join(",")).join("\n") + "\n";
  const plain = (value) => (Number.isFinite(value) ? String(value) : "");

  function rows_of_chart(id) {
    const all = series_of(id);
    const { x, y } = data[id];
    if (all.every((s) => s.x === all[0].x && !s.upper)) {
      const out = [[x, ...all.map((s) => s.name)]];
      all[0].x.forEach((at, k) => out.push([plain(at), ...all.map((s) => plain(s.y[k]))]));
      return out;
    }
    const out = [["series", x, y, "upper"]];
    for (const s of all) {
      s.x.forEach((at, k) => out.push([s.name, plain(at), plain(s.y[k]), s.upper ? plain(s.upper[k]) : ""]));
    }
    return out;
  }
  function rows_of_map(id) {
    const { names } = data[id];
    const values = values_of(id);
    return [["", ...names], ...names.map((name, i) => [name, ...names.map((_, j) => plain(values[i * names.length + j]))])];
  }
  function rows_of_bodies(id) {
    const heading = ["link", "of", "mass [kg]", "x [m]", "y [m]", "z [m]"];
    const axes = ["a", "b", "c"].flatMap((a) => ["x", "y", "z"].map((c) => `semi-axis ${a}${c} [m]`));
    const points = data[id].traces.flatMap((t) => t.points.map((p) => [t.name, t.style, "", ...p, ...axes.map(() => "")]));
    return [[...heading, ...axes], ...data[id].bodies.map((b) => [b.name, b.style, b.mass, ...b.centre, ...b.axes]), ...points];
  }
  const rows_of = (id) =>
    data[id].rows ?? (data[id].series ? rows_of_chart(id) : data[id].names ? rows_of_map(id) : rows_of_bodies(id));

  // The picture alone, in the colours of paper, with all that the style sheet says of it.
  function svg_of(figure) {
    const original = figure.querySelector("svg");
    const light = root.classList.contains("paper");
    root.classList.add("paper");
    const copy = original.cloneNode(true);
    const parts = original.querySelectorAll("*");
    copy.querySelectorAll("*").forEach((part, k) => {
      const style = getComputedStyle(parts[k]);
      for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin", "opacity", "fill-opacity", "font-size"]) {
        part.setAttribute(name, style.getPropertyValue(name));
      }
    });
    root.classList.toggle("paper", light);
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("font-family", "sans-serif");
    return copy.outerHTML;
  }

  function save(text, name, type) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  function button(label, title, action) {
    const out = document.createElement("button");
    out.type = "button";
    out.textContent = label;
    out.title = title;
    out.addEventListener("click", action);
    return out;
  }

  for (const figure of figures.filter((each) => each.classList.contains("chart"))) {
    const { id } = figure;
    const tools = document.createElement("span");
    tools.className = "tools";
    const name = figure.querySelector("figcaption b").textContent;
    const link = document.createElement("a");
    link.href = "#" + id;
    link.textContent = "#";
    link.title = "Link to this plot";
    link.setAttribute("aria-label", "Link to " + name);
    const as_csv = button("CSV", "The numbers of this plot", () => save(csv(rows_of(id)), id + ".csv", "text/csv"));
    const as_svg = button("SVG", "This plot as a picture", () => save(svg_of(figure), id + ".svg", "image/svg+xml"));
    as_csv.setAttribute("aria-label", "CSV of " + name);
    as_svg.setAttribute("aria-label", "SVG of " + name);
    tools.append(as_csv, as_svg, link);
    figure.querySelector("figcaption").append(tools);
  }

  // ------------------------------------------------------------------ plots over time

  const of_log = (log) => over_time.filter((figure) => figure.dataset.log === log);

  // All plots of a log show the same time.
  function show_time(log, range) {
    ranges[log] = range;
    of_log(log).forEach(draw);
  }

  const moves = {
    in: (a, b) => [a + 0.25 * (b - a), b - 0.25 * (b - a)],
    out: (a, b) => [a - 0.5 * (b - a), b + 0.5 * (b - a)],
    back: (a, b) => [a - 0.5 * (b - a), b - 0.5 * (b - a)],
    forward: (a, b) => [a + 0.5 * (b - a), b + 0.5 * (b - a)],
    all: () => [-Infinity, Infinity],
  };
  // Within the log, and not narrower than a few rows.
  function show_part(log, [from, to]) {
    const t = series_of(of_log(log)[0].id)[0].x;
    const [first, last] = [t[0], t[t.length - 1]];
    const least = (4 * (last - first)) / t.length;
    const span = Math.max(Math.min(to - from, last - first), least);
    const min = Math.max(Math.min(from, last - span), first);
    show_time(log, { min, max: Math.min(min + span, last) });
  }
  function move(log, how) {
    const { x } = of_log(log).find((figure) => figure.plot).plot;
    show_part(log, moves[how](x.low, x.high));
  }

  // Above all plots of a log; that of the first screen, 0, stands for itself.
  function add_toolbar(log) {
    const buttons = [
      ["in", "+", "Zoom in"],
      ["out", "−", "Zoom out"],
      ["back", "‹", "Earlier"],
      ["forward", "›", "Later"],
      ["all", "all", "The whole log"],
    ];
    const toolbar = document.createElement("div");
    toolbar.className = "toolbar";
    for (const [how, sign, label] of buttons) {
      const item = button(sign, label, () => move(log, how));
      item.dataset.move = how;
      item.setAttribute("aria-label", label);
      toolbar.append(item);
    }
    const words = document.createElement("span");
    words.textContent = "Drag over a plot to zoom, double-click to see all.";
    toolbar.append(words);
    of_log(log)[0].closest(".group").before(toolbar);
  }

  // ------------------------------------------------------------------ values under the pointer

  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  document.body.append(tip);
  function show_tip(event, text) {
    tip.textContent = text;
    tip.hidden = text === "";
    const beside = event.clientX + tip.offsetWidth + 24 > innerWidth ? -tip.offsetWidth - 14 : 14;
    tip.style.left = event.clientX + beside + scrollX + "px";
    tip.style.top = event.clientY + 14 + scrollY + "px";
  }

  // The point of a chart that is nearest to the pointer.
  function nearest(figure, [left, top]) {
    const { x, y } = figure.plot;
    const reach = 24;
    let best = { distance: reach * reach, text: "" };
    for (const s of series_of(figure.id)) {
      if (s.hidden || s.kind === "band") {
        continue;
      }
      for (let k = 0; k < s.x.length; ++k) {
        const across = x.at(s.x[k]) - left;
        const up = s.kind === "bars" ? 0 : y.at(s.y[k]) - top;
        const distance = across * across + up * up;
        if (distance < best.distance) {
          best = { distance, text: `${s.name}: ${digits(s.x[k], 5)}, ${digits(s.y[k], 5)}` };
        }
      }
    }
    return best.text;
  }
  function cell_under(figure, at) {
    const { names } = data[figure.id];
    const [i, j] = figure.cell_at(at);
    return i >= 0 && j >= 0 && i < names.length && j < i
      ? `${names[i]} and ${names[j]}: ${digits(values_of(figure.id)[i * names.length + j], 3)}`
      : "";
  }
  // All curves at the time under the pointer, at which a line stands in each plot of the log.
  function at_time(figure, [left]) {
    const { x, frame } = figure.plot;
    const t = x.value(left);
    const inside = left >= frame.left && left <= frame.right;
    for (const other of of_log(figure.dataset.log)) {
      const cursor = other.querySelector(".cursor");
      const at = inside && other.plot ? tenths(other.plot.x.at(t)) : "";
      for (const [name, value] of Object.entries({ x1: at, x2: at, y1: 0, y2: at && data[other.id].height })) {
        cursor?.setAttribute(name, value);
      }
    }
    const shown = series_of(figure.id).filter((s) => !s.hidden);
    if (!inside || shown.length === 0) {
      return "";
    }
    const apart = (k) => Math.abs(shown[0].x[k] - t);
    const row = shown[0].part.reduce((best, k) => (apart(k) < apart(best) ? k : best));
    return [`t: ${digits(shown[0].x[row], 7)}`, ...shown.map((s) => `${s.name}: ${digits(s.y[row], 5)}`)].join(", ");
  }

  const point_of = (figure, event) => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(figure.querySelector("svg").getScreenCTM().inverse());
    return [x, y];
  };
  function read_values(figure, reader) {
    const place = place_of(figure);
    const show = (event, at) => show_tip(event, waiting.includes(figure) ? "" : reader(figure, at ?? point_of(figure, event)));
    place.addEventListener("pointermove", (event) => show(event));
    place.addEventListener("pointerleave", (event) => {
      show(event, [-1, -1]);
      tip.hidden = true;
    });
  }

  const keys = { ArrowLeft: "back", ArrowRight: "forward", "+": "in", "-": "out", 0: "all" };
  function zoom_by_hand(figure) {
    const { log } = figure.dataset;
    const place = place_of(figure);
    place.tabIndex = 0;
    place.setAttribute("role", "group");
    place.setAttribute("aria-label", data[figure.id].label + "; arrow keys move, plus and minus zoom, 0 shows all");
    place.addEventListener("keydown", (event) => {
      if (keys[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) {
        event.preventDefault();
        move(log, keys[event.key]);
      }
    });
    let from = null;
    const selected = (event) => [from, point_of(figure, event)[0]].sort((a, b) => a - b);
    place.addEventListener("pointerdown", (event) => {
      from = event.pointerType === "mouse" ? point_of(figure, event)[0] : null;
    });
    place.addEventListener("pointermove", (event) => {
      if (from !== null && event.buttons & 1) {
        const [left, right] = selected(event);
        const part = { x: left, width: right - left, y: 0, height: data[figure.id].height };
        for (const [name, value] of Object.entries(part)) {
          figure.querySelector(".selection").setAttribute(name, value);
        }
      }
    });
    addEventListener("pointerup", (event) => {
      if (from !== null) {
        const [left, right] = selected(event);
        from = null;
        const { x } = figure.plot;
        if (right - left > 4) {
          show_part(log, [x.value(left), x.value(right)]);
        }
      }
    });
    place.addEventListener("dblclick", () => move(log, "all"));
  }

  // ------------------------------------------------------------------ tables

  function sort_key(cell) {
    const text = cell ? cell.textContent.trim() : "";
    const value = parseFloat(text);
    return cell?.classList.contains("number") ? (Number.isFinite(value) ? value : Infinity) : text;
  }
  for (const table of document.querySelectorAll("table")) {
    const body = table.tBodies[0];
    if (!table.tHead || body.rows.length < 3) {
      continue;
    }
    [...table.tHead.rows[0].cells].forEach((heading, column) => {
      if (heading.textContent === "") {
        return;
      }
      const text = heading.textContent;
      heading.textContent = "";
      heading.append(
        button(text, "Sort by " + text, () => {
          const down = heading.getAttribute("aria-sort") === "ascending";
          for (const other of table.tHead.rows[0].cells) {
            other.removeAttribute("aria-sort");
          }
          heading.setAttribute("aria-sort", down ? "descending" : "ascending");
          const rows = [...body.rows].filter((row) => !row.classList.contains("sum"));
          const sums = [...body.rows].filter((row) => row.classList.contains("sum"));
          const compare = (a, b) => (typeof a === "number" ? (a < b ? -1 : Number(a > b)) : a.localeCompare(b));
          rows.sort((a, b) => (down ? -1 : 1) * compare(sort_key(a.cells[column]), sort_key(b.cells[column])));
          body.append(...rows, ...sums);
        }),
      );
    });
  }
  for (const scroller of document.querySelectorAll(".scroll")) {
    if (scroller.scrollWidth <= scroller.clientWidth) {
      continue;
    }
    scroller.tabIndex = 0; // so that its rest can be reached by keyboard
    scroller.setAttribute("role", "region");
    scroller.setAttribute("aria-label", scroller.closest("section")?.querySelector("h2")?.textContent ?? "Table");
  }

  // ------------------------------------------------------------------ making plots

  function draw(figure) {
    const { series, names, bodies, rows } = data[figure.id];
    (series ? draw_chart : names ? draw_map : bodies ? draw_bodies : rows ? draw_dots : draw_path)(figure);
  }
  // A few at a time, from the top, so that the page can be read meanwhile.
  const waiting = [...figures];
  function draw_some() {
    const until = performance.now() + 40;
    while (waiting.length > 0 && performance.now() < until) {
      draw(waiting.shift());
    }
    if (waiting.length > 0) {
      setTimeout(draw_some);
    }
  }
  charts.forEach(add_legend);
  draw_some();
  // Those as wide as the page are drawn again where that changes, and once the fold that they are in is opened.
  const watch = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      const figure = target.closest("figure");
      if (figure.plot && target.clientWidth > 0 && target.clientWidth !== figure.plot.width) {
        draw(figure);
      }
    }
  });
  charts.filter(is_wide).forEach((figure) => watch.observe(place_of(figure)));
  over_time.forEach(zoom_by_hand);
  new Set(over_time.map((figure) => figure.dataset.log).filter((log) => log !== "0")).forEach(add_toolbar);
  charts.forEach((figure) => read_values(figure, figure.dataset.log === undefined ? nearest : at_time));
  figures.filter((figure) => data[figure.id].names).forEach((figure) => read_values(figure, cell_under));
  figures.filter((figure) => data[figure.id].bodies).forEach(turn_by_hand);
  figures.filter((figure) => data[figure.id].poses?.length > 1).forEach(add_player);

  // On paper folded tables are open; plots of other logs stay folded.
  const opened = [];
  addEventListener("beforeprint", () => {
    for (const fold of document.querySelectorAll("details:not([open]):not(:has(.toolbar))")) {
      fold.open = true;
      opened.push(fold);
    }
  });
  addEventListener("afterprint", () => {
    for (const fold of opened.splice(0)) {
      fold.open = false;
    }
  });

  root.dataset.ready = Math.round(performance.now());
})();
