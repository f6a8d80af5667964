// What a reader can do with the page: zoom along time, read values, take numbers and pictures along, turn the robot, sort tables.
// #data holds the numbers of each figure by its id; without scripts the pictures of the page stand as they are.
(() => {
  "use strict";
  const root = document.documentElement;
  const data = JSON.parse(document.getElementById("data").textContent);
  const figures = [...document.querySelectorAll("figure.chart")].filter((figure) => data[figure.id]);

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
        });
      }
    }
    return chart.decoded;
  }
  const values_of = (id) => (data[id].decoded ??= decoded(data[id].values, false));

  const digits = (value, count) =>
    value === null || value === undefined || !Number.isFinite(value) ? "–" : String(Number(value.toPrecision(count)));

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
    const picture = figure.querySelector("svg");
    const light = root.classList.contains("paper");
    root.classList.add("paper");
    const copy = picture.cloneNode(true);
    const parts = picture.querySelectorAll("*");
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

  for (const figure of figures) {
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

  let colours = {};
  function read_colours() {
    const style = getComputedStyle(root);
    for (const name of ["text", "soft", "line", "grid", "measured", "predicted", "residual", "apriori"]) {
      colours[name] = style.getPropertyValue("--" + name).trim();
    }
  }

  const made = new Map(); // figure → plot
  const ranges = {}; // of the time of each log

  function axis(label, more) {
    return {
      label,
      labelSize: 18,
      labelFont: "12px system-ui, sans-serif",
      font: "11px system-ui, sans-serif",
      stroke: colours.soft,
      grid: { stroke: colours.grid, width: 1 },
      ticks: { stroke: colours.line, width: 1, size: 4 },
      ...more,
    };
  }

  // A curve that lifts the pen where rows are left out: uPlot's own draws over a gap and erases that.
  function stroke_of(u, index, first, last) {
    const stroke = new Path2D();
    const [x, y] = [u.data[0], u.data[index]];
    let down = false;
    for (let k = first; k <= last; ++k) {
      if (y[k] === null) {
        down = false;
        continue;
      }
      const at = [u.valToPos(x[k], "x", true), u.valToPos(y[k], u.series[index].scale, true)];
      down ? stroke.lineTo(...at) : stroke.moveTo(...at);
      down = true;
    }
    return { stroke, fill: null };
  }

  // All plots of a log show the same time.
  function follow(log) {
    return (u, scale) => {
      const { min, max } = u.scales.x;
      const known = ranges[log];
      if (scale !== "x" || min === null || (known && known.min === min && known.max === max)) {
        return;
      }
      ranges[log] = { min, max };
      for (const [figure, plot] of made) {
        if (plot !== u && figure.dataset.log === log) {
          plot.setScale("x", { min, max });
        }
      }
    };
  }

  function make(figure) {
    const { id, dataset } = figure;
    const { log } = dataset;
    const chart = data[id];
    const all = series_of(id);
    const known = made.get(figure);
    const shown = known ? known.series.map((s) => s.show) : null;
    known?.destroy();
    const place = figure.querySelector(".picture");
    place.classList.add("live");
    const span = ranges[log] ?? { min: all[0].x[0], max: all[0].x[all[0].x.length - 1] };
    const plot = new uPlot(
      {
        width: place.clientWidth,
        height: chart.height,
        scales: { x: { time: false, ...span } },
        axes: [
          axis(chart.x, { size: 28, gap: 3 }),
          axis(chart.y, { size: 56, gap: 3, space: Math.min(26, chart.height / 10), values: (u, ticks) => ticks.map((v) => (v === null ? "" : digits(v, 6))) }),
        ],
        series: [
          { label: "t", value: (u, v) => digits(v, 7) },
          ...all.map((s, k) => ({
            label: s.name,
            stroke: colours[s.style],
            width: s.style === "measured" ? 2.2 : 1.2,
            show: shown ? shown[k + 1] : !s.on_demand,
            paths: stroke_of,
            points: { show: false },
            value: (u, v) => digits(v, 5),
          })),
        ],
        cursor: {
          drag: { x: true, y: false, dist: 4 },
          sync: {
            key: "log " + log,
            scales: ["x", null],
            filters: { pub: (type) => type === "mousemove" || type === "mouseleave" },
          },
        },
        hooks: { setScale: [follow(log)] },
      },
      [all[0].x, ...all.map((s) => Array.from(s.y, (v) => (Number.isNaN(v) ? null : v)))],
      place,
    );
    made.set(figure, plot);
    figure.plot = plot; // for whoever looks from the console
  }

  const moves = {
    in: (a, b) => [a + 0.25 * (b - a), b - 0.25 * (b - a)],
    out: (a, b) => [a - 0.5 * (b - a), b + 0.5 * (b - a)],
    back: (a, b) => [a - 0.5 * (b - a), b - 0.5 * (b - a)],
    forward: (a, b) => [a + 0.5 * (b - a), b + 0.5 * (b - a)],
    all: () => [-Infinity, Infinity],
  };
  function move(log, how) {
    const figure = over_time.find((f) => f.dataset.log === log);
    const t = series_of(figure.id)[0].x;
    const first = t[0];
    const last = t[t.length - 1];
    const shown = ranges[log] ?? { min: first, max: last };
    let [min, max] = moves[how](shown.min, shown.max);
    const least = (4 * (last - first)) / t.length;
    const span = Math.max(Math.min(max - min, last - first), least);
    min = Math.max(Math.min(min, last - span), first);
    ranges[log] = { min, max: Math.min(min + span, last) };
    for (const [each, plot] of made) {
      if (each.dataset.log === log) {
        plot.setScale("x", ranges[log]);
      }
    }
  }

  const over_time = figures.filter((figure) => figure.dataset.log !== undefined);
  for (const toolbar of document.querySelectorAll(".toolbar")) {
    toolbar.addEventListener("click", (event) => {
      if (event.target.dataset.move) {
        move(toolbar.dataset.log, event.target.dataset.move);
      }
    });
  }
  const keys = { ArrowLeft: "back", ArrowRight: "forward", "+": "in", "-": "out", 0: "all" };
  for (const figure of over_time) {
    const place = figure.querySelector(".picture");
    place.tabIndex = 0;
    place.setAttribute("role", "group");
    place.setAttribute("aria-label", figure.querySelector("svg title").textContent + "; arrow keys move, plus and minus zoom, 0 shows all");
    place.addEventListener("keydown", (event) => {
      if (keys[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) {
        event.preventDefault();
        move(figure.dataset.log, keys[event.key]);
      }
    });
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

  // The point of a picture that is nearest to the pointer.
  function nearest(figure, at) {
    const picture = figure.querySelector("svg");
    const [left, top, right, bottom] = picture.dataset.frame.split(" ").map(Number);
    const [x0, x1] = picture.dataset.x.split(" ").map(Number);
    const [y0, y1] = picture.dataset.y.split(" ").map(Number);
    const { logarithmic } = data[figure.id];
    const reach = 24;
    let best = { distance: reach * reach, text: "" };
    for (const s of series_of(figure.id)) {
      if (s.on_demand || s.kind === "band") {
        continue;
      }
      for (let k = 0; k < s.x.length; ++k) {
        const across = left + ((s.x[k] - x0) / (x1 - x0)) * (right - left) - at.x;
        const height = logarithmic ? Math.log10(s.y[k]) : s.y[k];
        const up = s.kind === "bars" ? 0 : bottom - ((height - y0) / (y1 - y0)) * (bottom - top) - at.y;
        const distance = across * across + up * up;
        if (distance < best.distance) {
          best = { distance, text: `${s.name}: ${digits(s.x[k], 5)}, ${digits(s.y[k], 5)}` };
        }
      }
    }
    return best.text;
  }
  function cell_under(figure, at) {
    const [left, top, size] = figure.querySelector("svg").dataset.heat.split(" ").map(Number);
    const { names } = data[figure.id];
    const i = Math.floor((at.y - top) / size);
    const j = Math.floor((at.x - left) / size);
    return i >= 0 && j >= 0 && i < names.length && j < i
      ? `${names[i]} and ${names[j]}: ${digits(values_of(figure.id)[i * names.length + j], 3)}`
      : "";
  }
  for (const figure of figures) {
    const picture = figure.querySelector("svg");
    const reader = picture.dataset.frame ? nearest : picture.dataset.heat ? cell_under : null;
    if (reader && figure.dataset.log === undefined) {
      picture.addEventListener("pointermove", (event) => {
        const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
        show_tip(event, reader(figure, at));
      });
      picture.addEventListener("pointerleave", () => (tip.hidden = true));
    }
  }

  // ------------------------------------------------------------------ the robot

  function turn_by_hand(figure) {
    const picture = figure.querySelector("svg");
    const { joints, bodies, traces } = data[figure.id];
    const { width, height } = picture.viewBox.baseVal;
    const ellipses = [...picture.querySelectorAll("ellipse")];
    const arm = picture.querySelector("polyline.arm");
    const lines = [...picture.querySelectorAll("polyline.trace")];
    const dots = [...picture.querySelectorAll("circle")];
    const places = [...joints, ...traces.flatMap((t) => t.points)];
    const middle = [0, 1, 2].map((c) => {
      const values = places.map((p) => p[c]);
      return 0.5 * (Math.min(...values) + Math.max(...values));
    });
    const longest = (axes) => Math.max(...[0, 3, 6].map((a) => Math.hypot(...axes.slice(a, a + 3))));
    const far = Math.max(
      ...places.map((p) => Math.hypot(...p.map((v, c) => v - middle[c]))),
      ...bodies.map((b) => Math.hypot(...b.centre.map((v, c) => v - middle[c])) + longest(b.axes)),
    );
    const pixels = (0.5 * Math.min(width, height) - 10) / far;
    let yaw = -0.9;
    let pitch = 0.42;
    function draw() {
      const right = [Math.cos(yaw), Math.sin(yaw), 0];
      const down = [Math.sin(pitch) * Math.sin(yaw), -Math.sin(pitch) * Math.cos(yaw), -Math.cos(pitch)];
      const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      const at = (p) => {
        const v = p.map((value, c) => value - middle[c]);
        return [0.5 * width + pixels * dot(right, v), 0.5 * height + pixels * dot(down, v)];
      };
      const text = (points) => points.map((p) => p.map((v) => v.toFixed(1)).join(",")).join(" ");
      const points = joints.map(at);
      arm.setAttribute("points", text(points));
      lines.forEach((line, k) => line.setAttribute("points", text(traces[k].points.map(at))));
      dots.forEach((d, k) => {
        d.setAttribute("cx", points[k][0].toFixed(1));
        d.setAttribute("cy", points[k][1].toFixed(1));
      });
      ellipses.forEach((ellipse, k) => {
        // The outline of the projected ellipsoid: eigenvalues of (P A)(P A)ᵀ.
        let [xx, xy, yy] = [0, 0, 0];
        for (let a = 0; a < 9; a += 3) {
          const axis_k = bodies[k].axes.slice(a, a + 3);
          const [x, y] = [dot(right, axis_k), dot(down, axis_k)];
          xx += x * x;
          xy += x * y;
          yy += y * y;
        }
        const mean = 0.5 * (xx + yy);
        const apart = Math.hypot(0.5 * (xx - yy), xy);
        const angle = (0.5 * Math.atan2(2 * xy, xx - yy) * 180) / Math.PI;
        const [x, y] = at(bodies[k].centre);
        ellipse.setAttribute("rx", (pixels * Math.sqrt(mean + apart)).toFixed(1));
        ellipse.setAttribute("ry", (pixels * Math.sqrt(Math.max(mean - apart, 0))).toFixed(1));
        ellipse.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${angle.toFixed(1)})`);
      });
    }
    function turn(across, up) {
      yaw += across;
      pitch = Math.max(-1.55, Math.min(1.55, pitch + up));
      draw();
    }
    const place = figure.querySelector(".picture");
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
    draw();
  }
  figures.filter((figure) => data[figure.id].bodies).forEach(turn_by_hand);

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
  for (const scroller of document.querySelectorAll(".scroll, .wide .picture:not([tabindex])")) {
    if (scroller.scrollWidth <= scroller.clientWidth) {
      continue;
    }
    scroller.tabIndex = 0; // so that its rest can be reached by keyboard
    scroller.setAttribute("role", "region");
    scroller.setAttribute("aria-label", scroller.closest("section")?.querySelector("h2")?.textContent ?? "Table");
  }

  // ------------------------------------------------------------------ making plots

  // A few at a time, from the top, so that the page can be read meanwhile; those in a fold when it is opened.
  function make_plots() {
    const until = performance.now() + 40;
    const waiting = over_time.filter((figure) => !made.has(figure) && figure.querySelector(".picture").clientWidth > 0);
    while (waiting.length > 0 && performance.now() < until) {
      make(waiting.shift());
    }
    root.dataset.plots = made.size;
    if (waiting.length > 0) {
      setTimeout(make_plots);
    }
  }
  document.addEventListener("toggle", make_plots, true);
  read_colours();
  make_plots();

  new ResizeObserver(() => {
    for (const [figure, plot] of made) {
      const { clientWidth } = figure.querySelector(".picture");
      if (clientWidth > 0 && clientWidth !== plot.width) {
        plot.setSize({ width: clientWidth, height: plot.height });
      }
    }
  }).observe(document.querySelector("main"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    read_colours();
    [...made.keys()].forEach(make);
  });
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
