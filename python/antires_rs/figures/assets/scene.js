// Draws a structure in space that can be turned. Each pixel knows its depth and its cell; nothing is fetched.
window.drawScene = function (place, data) {
  "use strict";
  const summed = (list, width) => {
    const out = Int32Array.from(list);
    for (let i = width; i < out.length; i++) out[i] += out[i - width];
    return out;
  };
  const points = summed(data.points, 3), cells = summed(data.cells, 4), parts = summed(data.parts, 1);
  const moves = Object.entries(data.moves).map(([name, list]) => [name, summed(list, 3)]);
  const rgb = data.colours.map((c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16)));
  const n = points.length / 3, m = parts.length, none = rgb.length - 1;
  const middle = [0, 1, 2].map((k) => {
    let low = Infinity, high = -Infinity;
    for (let i = k; i < points.length; i += 3) { low = Math.min(low, points[i]); high = Math.max(high, points[i]); }
    return (low + high) / 2;
  });
  // -- What stands around the canvas
  const make = (tag, style, text, parent) => {
    const one = document.createElement(tag);
    one.style.cssText = style;
    one.textContent = text;
    (parent || place).appendChild(one);
    return one;
  };
  const bar = make("div", "display:flex;flex-wrap:wrap;gap:.3rem .7rem;align-items:center;font-size:.85rem", "");
  const canvas = make("canvas", "display:block;width:100%;border:1px solid #d0d7de;margin:.4rem 0;cursor:grab;touch-action:pan-y", "");
  const told = make("div", "min-height:1.5em;font-size:.9rem", "");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "Structure in space: arrow keys turn it, + and - zoom, 0 goes back");
  const hint = "Drag to turn, with Shift to move; after a click the wheel zooms. Point at a part to read it.";
  told.textContent = hint;
  const button = (text, about, act) => {
    const one = make("button", "font:inherit;min-width:2em", text, bar);
    one.title = about;
    one.onclick = () => { act(); show(); };
  };
  let azimuth = Math.PI / 4, elevation = Math.asin(Math.sqrt(1 / 3)), zoom = 1, shift = [0, 0], chosen = -1;
  const back = () => { azimuth = Math.PI / 4; elevation = Math.asin(Math.sqrt(1 / 3)); zoom = 1; shift = [0, 0]; };
  button("+", "nearer", () => { zoom *= 1.25; });
  button("\u2212", "farther", () => { zoom /= 1.25; });
  button("Reset", "as at first", back);
  let ghost = false;
  const box = document.createElement("input");
  box.type = "checkbox";
  if (data.hit.some((one) => one)) {
    const label = make("label", "", "", bar);
    label.appendChild(box);
    label.append(" see through what is intact");
    box.onchange = () => { ghost = box.checked; show(); };
  }
  if (moves.length) {
    const select = make("select", "font:inherit", "", bar);
    ["at rest", ...moves.map(([name]) => name)].forEach((name) => make("option", "", name, select));
    select.setAttribute("aria-label", "motion");
    select.onchange = () => { chosen = select.selectedIndex - 1; show(); };
  }
  for (const one of data.arrows) {
    const label = make("span", "", "", bar);
    make("span", `color:${one.colour};font-weight:${one.width > 1.5 ? 900 : 400}`, "\u279e", label);
    label.append(` ${one.label}`);
  }
  if (data.scale.length) {
    const [name, low, high, ...stops] = data.scale, label = make("span", "white-space:nowrap", `${name}: ${low.toPrecision(2) * 1} `, bar);
    make("span", `display:inline-block;width:6em;height:.8em;border:1px solid #8c8c8c;background:linear-gradient(to right,${stops})`, "", label);
    label.append(` ${high.toPrecision(3) * 1}`);
  }
  // -- Drawing: triangles into a depth and a cell for each pixel, then colours, outlines, arrows and names
  const x = new Float32Array(n), y = new Float32Array(n), z = new Float32Array(n), light = new Uint8Array(m);
  const pen = canvas.getContext("2d");
  function sized(coarse) {
    const css = place.clientWidth, tall = Math.round(Math.min(Math.max(0.56 * css, 260), 620));
    ratio = coarse ? 1 : Math.min(2, Math.sqrt(2e6 / (css * tall)));
    canvas.style.height = `${tall}px`;
    wide = canvas.width = Math.round(css * ratio);
    high = canvas.height = Math.round(tall * ratio);
    image = pen.createImageData(wide, high);
    pixels = new Uint32Array(image.data.buffer);
    depth = new Float32Array(wide * high);
    cell = new Int32Array(wide * high);
    fit = 0.42 * Math.min(wide / extent[0], high / extent[1]);
  }
  let fit = 1, wide = 0, high = 0, ratio = 1, image, pixels, depth, cell, extent = [1, 1];
  function view() {
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth), ce = Math.cos(elevation), se = Math.sin(elevation);
    const s = fit * zoom;
    return [s * ca, s * sa, s * sa * se, -s * ca * se, -s * ce, s * sa * ce, -s * ca * ce, s * se];
  }
  // Across, down and towards the eye, in pixels.
  function seen(a, px, py, pz) {
    const u = px - middle[0], v = py - middle[1], w = pz - middle[2];
    return [wide / 2 + ratio * shift[0] + a[0] * u + a[1] * v, high / 2 + ratio * shift[1] + a[2] * u + a[3] * v + a[4] * w, a[5] * u + a[6] * v + a[7] * w];
  }
  function triangle(id, ax, ay, az, bx, by, bz, cx, cy, cz) {
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (!area) return;
    const left = Math.max(0, Math.ceil(Math.min(ax, bx, cx))), right = Math.min(wide - 1, Math.floor(Math.max(ax, bx, cx)));
    const top = Math.max(0, Math.ceil(Math.min(ay, by, cy))), under = Math.min(high - 1, Math.floor(Math.max(ay, by, cy)));
    const see = ghost && !data.hit[parts[id]], dp = (by - cy) / area, dq = (cy - ay) / area;
    for (let j = top; j <= under; j++) {
      let p = ((bx - left) * (cy - j) - (by - j) * (cx - left)) / area;
      let q = ((cx - left) * (ay - j) - (cy - j) * (ax - left)) / area;
      for (let i = left, at = j * wide + left; i <= right; i++, at++, p += dp, q += dq) {
        if (p < -1e-6 || q < -1e-6 || p + q > 1.000001 || (see && (i ^ j) & 3)) continue;
        const near = cz + p * (az - cz) + q * (bz - cz);
        if (near > depth[at]) { depth[at] = near; cell[at] = id; }
      }
    }
  }
  function raster(share) {
    const axes = view(), move = chosen < 0 ? null : moves[chosen][1];
    for (let i = 0; i < n; i++) {
      const k = 3 * i, d = move ? share : 0;
      const p = seen(axes, points[k] + (d && d * move[k]), points[k + 1] + (d && d * move[k + 1]), points[k + 2] + (d && d * move[k + 2]));
      x[i] = p[0]; y[i] = p[1]; z[i] = p[2];
    }
    depth.fill(-Infinity);
    cell.fill(-1);
    let area = 0, faces = 0;
    for (let c = 0; c < m; c++) {
      const a = cells[4 * c], b = cells[4 * c + 1], e = cells[4 * c + 2], f = cells[4 * c + 3];
      if (b === e) { // a line is a narrow band that faces the eye, a little before the faces that it stiffens
        const dx = x[b] - x[a], dy = y[b] - y[a], pale = parts[c] < 0 || data.bare[parts[c]];
        const half = ((pale ? 0.7 : 2.2) * ratio) / (Math.hypot(dx, dy) || 1);
        const u = -dy * half, v = dx * half, over = 2 * ratio;
        light[c] = pale ? 120 : 255;
        triangle(c, x[a] + u, y[a] + v, z[a] + over, x[a] - u, y[a] - v, z[a] + over, x[b] + u, y[b] + v, z[b] + over);
        triangle(c, x[b] + u, y[b] + v, z[b] + over, x[a] - u, y[a] - v, z[a] + over, x[b] - u, y[b] - v, z[b] + over);
        continue;
      }
      const p = [x[b] - x[a], y[b] - y[a], z[b] - z[a]], q = [x[e] - x[a], y[e] - y[a], z[e] - z[a]];
      const nx = p[1] * q[2] - p[2] * q[1], ny = p[2] * q[0] - p[0] * q[2], nz = p[0] * q[1] - p[1] * q[0];
      // From the upper left, behind the eye; little, so that colours can be read.
      const lit = Math.max(0, (0.7 * nz - 0.35 * nx - 0.62 * ny) * Math.sign(nz)) / (Math.hypot(nx, ny, nz) || 1);
      light[c] = 255 * (0.74 + 0.26 * lit);
      area += Math.abs(nz);
      faces++;
      triangle(c, x[a], y[a], z[a], x[b], y[b], z[b], x[e], y[e], z[e]);
      if (e !== f) triangle(c, x[a], y[a], z[a], x[e], y[e], z[e], x[f], y[f], z[f]);
    }
    return faces ? Math.sqrt(area / faces) / ratio : 99; // roughly the side of a face in px
  }
  function colour(side) {
    const each = side > 5;
    for (let j = 0, at = 0; j < high; j++) {
      for (let i = 0; i < wide; i++, at++) {
        const own = cell[at];
        if (own < 0) { pixels[at] = 0xffffffff; continue; }
        const part = parts[own], base = rgb[part < 0 ? none : part], lit = light[own];
        let shade = lit / 255;
        const right = i + 1 < wide ? cell[at + 1] : own, under = j + 1 < high ? cell[at + wide] : own;
        if ((right !== own || under !== own) && !ghost && lit !== 120) {
          const out = right < 0 || under < 0;
          if (out || parts[right] !== part || parts[under] !== part) shade *= 0.45;
          else if (Math.abs(light[right] - lit) > 16 || Math.abs(light[under] - lit) > 16) shade *= 0.6;
          else if (each) shade *= 0.8;
        }
        pixels[at] = 0xff000000 | ((base[2] * shade) << 16) | ((base[1] * shade) << 8) | (base[0] * shade);
      }
    }
    pen.putImageData(image, 0, 0);
  }
  function over() {
    const axes = view();
    for (const one of data.arrows) {
      one.heads.forEach((head, i) => {
        const a = seen(axes, ...one.tails[i]), b = seen(axes, ...head), turn = Math.atan2(b[1] - a[1], b[0] - a[0]);
        const size = 8 * ratio * Math.sqrt(one.width), rim = 1.3 * ratio;
        for (const [colour, more] of [["#fff", rim], [one.colour, 0]]) { // a white rim, seen on dark faces
          pen.strokeStyle = pen.fillStyle = colour;
          pen.lineWidth = 1.3 * ratio * one.width + 2 * more;
          pen.beginPath();
          pen.moveTo(a[0], a[1]);
          pen.lineTo(b[0] - 0.6 * size * Math.cos(turn), b[1] - 0.6 * size * Math.sin(turn));
          pen.stroke();
          pen.beginPath();
          pen.moveTo(b[0], b[1]);
          for (const way of [0.4, -0.4]) pen.lineTo(b[0] - size * Math.cos(turn + way), b[1] - size * Math.sin(turn + way));
          pen.closePath();
          pen.lineWidth = 2 * more;
          if (more) pen.stroke();
          pen.fill();
        }
      });
    }
    const word = (text, at, across) => {
      pen.textAlign = across;
      pen.lineWidth = 3.5 * ratio;
      pen.strokeStyle = "#fff";
      pen.lineJoin = "round";
      pen.strokeText(text, at[0], at[1]);
      pen.fillStyle = "#1f2328";
      pen.fillText(text, at[0], at[1]);
    };
    pen.font = `${12 * ratio}px system-ui, sans-serif`;
    pen.textBaseline = "middle";
    for (const [text, ...at] of data.named) {
      const p = seen(axes, ...at), half = pen.measureText(text).width / 2 + 4 * ratio;
      word(text, [Math.min(Math.max(p[0], half), wide - half), p[1] - 12 * ratio], "center");
    }
    const foot = [34 * ratio, high - 34 * ratio], origin = seen(axes, ...middle); // the axes, in a corner
    [["x", 1, 0, 0], ["y", 0, 1, 0], ["z", 0, 0, 1]].forEach(([name, ...way]) => {
      const p = seen(axes, ...way.map((w, k) => middle[k] + (w * 20 * ratio) / (fit * zoom)));
      const end = [foot[0] + p[0] - origin[0], foot[1] + p[1] - origin[1]];
      pen.strokeStyle = "#57606a";
      pen.lineWidth = 1.2 * ratio;
      pen.beginPath();
      pen.moveTo(foot[0], foot[1]);
      pen.lineTo(end[0], end[1]);
      pen.stroke();
      word(name, [end[0] + 0.35 * (end[0] - foot[0]), end[1] + 0.35 * (end[1] - foot[1])], "center");
    });
  }
  let asked = 0, still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  function show() {
    if (!asked) asked = requestAnimationFrame(frame);
  }
  function frame(now) {
    asked = 0;
    const begun = performance.now();
    colour(raster(still ? 1 : Math.sin(now / 250)));
    over();
    const took = performance.now() - begun;
    place.dataset.ms = took.toFixed(0);
    if (held && took > 80 && ratio > 1) sized(true); // coarse as long as it is turned
    if (chosen >= 0 && !still) { // a slow one stands at its largest motion
      if (took > 150) still = true;
      show();
    }
  }
  // -- Turning, moving, zooming, reading
  let held = null;
  canvas.onpointerdown = (event) => {
    held = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
  };
  canvas.onpointerup = canvas.onpointercancel = () => {
    held = null;
    sized();
    show();
  };
  canvas.onpointermove = (event) => {
    if (!held) return read(event);
    const dx = event.clientX - held[0], dy = event.clientY - held[1];
    held = [event.clientX, event.clientY];
    if (event.shiftKey) shift = [shift[0] + dx, shift[1] + dy];
    else turn(-dx / 150, dy / 150);
    show();
  };
  function turn(across, up) {
    azimuth += across;
    elevation = Math.min(Math.max(elevation + up, -Math.PI / 2), Math.PI / 2);
  }
  function read(event) {
    const box = canvas.getBoundingClientRect();
    const i = Math.floor((event.clientX - box.left) * ratio), j = Math.floor((event.clientY - box.top) * ratio);
    const own = i >= 0 && j >= 0 && i < wide && j < high ? cell[j * wide + i] : -1;
    told.textContent = own < 0 ? hint : parts[own] < 0 ? "of no group" : data.texts[parts[own]];
  }
  canvas.onwheel = (event) => {
    if (document.activeElement !== canvas) return; // else the page scrolls
    event.preventDefault();
    zoom *= Math.exp(-event.deltaY / 600);
    show();
  };
  const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  canvas.onkeydown = (event) => {
    if (keys[event.key]) turn(...keys[event.key]);
    else if (event.key === "+") zoom *= 1.25;
    else if (event.key === "-") zoom /= 1.25;
    else if (event.key === "0") back();
    else return;
    event.preventDefault();
    show();
  };
  new ResizeObserver(() => {
    if (Math.round(place.clientWidth * ratio) !== wide) { sized(); show(); }
  }).observe(place);
  for (let i = 0, axes = view(); i < n; i++) { // how far it reaches from its middle, as it is seen at first
    const p = seen(axes, points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    extent = extent.map((most, k) => Math.max(most, Math.abs(p[k])));
  }
  sized();
  raster(0);
  const there = new Set();
  for (let at = 0; at < cell.length; at += 3) if (cell[at] >= 0) there.add(parts[cell[at]]);
  ghost = box.checked = data.hit.some((one, part) => one && !there.has(part)); // what would not be seen at all
  show();
};
