// The page of `antires look`: shows what the server tells, sends what is clicked. Nothing else is asked of anyone.
"use strict";

const token = document.documentElement.dataset.token;
const $ = (id) => document.getElementById(id);
let state = null;
let shown = 0;
let figures = null; // what Bokeh embedded
let busy = 0;
let written = null; // band and orders that stand in their fields
// Both are on their way at once: what draws, and what is drawn.
const bokeh = new Promise((done) => {
  if (window.Bokeh) done();
  else document.getElementById("bokeh").addEventListener("load", done);
});

function address(path, more = {}) {
  return path + "?" + new URLSearchParams({ token, shown, ...more });
}

function say(text, wrong = false) {
  $("said").textContent = text;
  $("said").classList.toggle("wrong", wrong);
}

async function ask(path, body) {
  const options = body === undefined ? {} : { method: "POST", body: JSON.stringify(body) };
  let answer;
  try {
    answer = await fetch(address(path), options);
  } catch {
    throw new Error("The server has ended; start the command again.");
  }
  if (!answer.ok) throw new Error(await answer.text());
  const data = await answer.json();
  if (data.error) throw Object.assign(new Error(data.error), { taken: data.taken });
  return data;
}

// The state that an answer tells, unless a newer one is shown already; of the response that is shown now.
async function take(told) {
  if (state && told.turn < state.turn) return;
  state = told.dof !== shown ? await ask("state") : told;
}

async function act(command, body = {}, waiting = "") {
  busy += 1;
  if (waiting) say(waiting);
  $("said").classList.toggle("busy", Boolean(waiting));
  $("identify").disabled = true;
  try {
    const before = state;
    const told = await ask("do/" + command, body);
    await take(told);
    say(told.said);
    if (before && state.edits.length > before.edits.length && body.reason && $("reason").value === body.reason) {
      $("reason").value = ""; // it was that of this edit
    }
    write();
    // Another diagram stands behind the values: the figures are made anew, else only their marks move.
    const same = before && before.identified === state.identified && String(before.band_hz) === String(state.band_hz) &&
      before.max_order === state.max_order;
    if (same) mark();
    else await draw(false);
    return { done: true };
  } catch (error) {
    say(error.message, true);
    return { taken: error.taken };
  } finally {
    busy -= 1;
    $("said").classList.remove("busy");
    $("identify").disabled = busy > 0;
  }
}

// The marks of the values in every figure that has them.
function mark() {
  if (!figures) return;
  for (const root of figures.roots) {
    for (const one of root.model.references()) {
      if (state.marks[one.name]) one.data = { ...state.marks[one.name] };
      const kind = one.name?.startsWith("entry of ") ? one.name.slice(9) : null;
      if (kind) one.visible = state.marks[kind].x.length > 0;
    }
  }
}

async function draw(anew = true, asked = null) {
  const place = $("pictures");
  const height = place.offsetHeight;
  const kept = anew ? null : range();
  const band = state.band_hz;
  try {
    const made = await (asked ?? ask("figure"));
    await bokeh;
    place.style.minHeight = height + "px"; // what is below stays where it is
    clear();
    const target = element("div", { id: "evidence" });
    place.replaceChildren(target);
    figures = await Bokeh.embed.embed_item(made, target);
    for (const plot of plots()) listen(plot.model);
    if (kept && band && kept[0] >= band[0] && kept[1] <= band[1]) zoom(kept);
    place.dataset.drawn = shown;
    place.dataset.at ??= performance.timeOrigin + performance.now();
  } catch (error) {
    console.error(error);
    say(error.message, true);
  } finally {
    place.style.minHeight = "";
  }
}

function clear() {
  if (!figures) return;
  for (const root of [...figures.roots]) {
    const at = Bokeh.documents.indexOf(root.model.document);
    root.remove();
    if (at >= 0) Bokeh.documents.splice(at, 1);
  }
  figures = null;
}

function plots() {
  const found = [];
  const walk = (view) => (view.frame ? found.push(view) : (view.child_views ?? []).forEach(walk));
  if (figures) figures.roots.forEach(walk);
  return found;
}

function range() {
  const plot = plots()[0];
  return plot ? [plot.model.x_range.start, plot.model.x_range.end] : null;
}

function zoom([start, end]) {
  const plot = plots()[0];
  if (plot) plot.model.x_range.setv({ start, end });
}

function listen(model) {
  model.on_event("tap", (event) => {
    const per = (range, pixels) => Math.abs(range.end - range.start) / Math.max(pixels, 1);
    act("click", { dof: shown, figure: model.name, x: event.x, y: event.y, reason: $("reason").value,
      x_per_px: per(model.x_range, model.inner_width), y_per_px: per(model.y_range, model.inner_height) });
  });
  model.document.event_manager.subscribed_models.add(model);
}

async function show(dof) {
  shown = (dof + state.dofs.length) % state.dofs.length;
  const kept = range();
  try {
    state = await ask("state");
    write();
    const row = document.querySelector("#values tr.shown");
    if (row) $("values").parentElement.scrollTop = row.offsetTop - 40; // of the table alone, not of the window
    await draw(kept === null);
  } catch (error) {
    say(error.message, true);
  }
}

// "12,5" is meant as 12.5.
function number(text) {
  const value = Number(text.trim().replace(",", "."));
  return text.trim() && Number.isFinite(value) ? value : null;
}

async function save() {
  const { taken } = await act("save");
  if (taken && confirm(`${$("said").textContent}\n\nReplace it?`)) await act("save", { replace: true });
}

function identify() {
  const low = number($("low").value), high = number($("high").value);
  const typed = $("order").value.trim(), order = typed ? number(typed) : null;
  if (low === null || high === null) return say("The band: two numbers in Hz.", true);
  if (typed && order === null) return say("The highest order: a whole number, or nothing.", true);
  return act("identify", { low_hz: low, high_hz: high, max_order: order }, "Identifying …");
}

function wire() {
  $("response").addEventListener("change", (event) => show(Number(event.target.value)));
  $("previous").addEventListener("click", () => show(shown - 1));
  $("next").addEventListener("click", () => show(shown + 1));
  $("save").addEventListener("click", save);
  $("controls").addEventListener("submit", (event) => {
    event.preventDefault();
    if (event.submitter?.id === "identify" && document.activeElement !== $("reason")) identify();
  });
  $("adding").addEventListener("submit", async (event) => {
    event.preventDefault();
    const value = number($("value").value);
    if (value === null) return say("A frequency in Hz.", true);
    if ((await act("add", { dof: shown, freq_hz: value, reason: $("reason").value })).done) $("value").value = "";
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || !state || event.key.toLowerCase() !== "s") return;
    event.preventDefault();
    save();
  });
  addEventListener("beforeunload", (event) => {
    if (state?.unsaved && !ended) event.preventDefault();
  });
}

let ended = false;
function live() {
  // The server knows by this that the page is open, the page by its end that the server is not.
  const socket = new WebSocket("ws://" + location.host + "/alive?" + new URLSearchParams({ token }));
  socket.addEventListener("close", () => {
    ended = true;
    if (state) say("The server has ended; this page can be closed.", true);
  });
}

async function begin() {
  wire();
  live();
  try {
    const first = ask("figure");
    first.catch(() => {}); // told where it is waited for
    state = await ask("state");
    write();
    say(!state.identified ? "Identifying …" : "");
    await draw(true, first);
    if (!state.identified) await identify();
  } catch (error) {
    say(error.message, true);
  }
}

begin();
