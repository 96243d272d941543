// What every page needs: reading data that may be poor, numbers as text, elements. Every text from a file goes through textContent.

const list = (value) => (Array.isArray(value) ? value : []);
const record = (value) => (value && typeof value === "object" && !Array.isArray(value) ? value : {});
const finite = (value) => typeof value === "number" && Number.isFinite(value);
const number = (value, otherwise = 0) => (finite(value) ? value : otherwise);
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const wrap = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
const pointsOf = (rows) => list(rows).filter((row) => Array.isArray(row) && finite(row[0]) && finite(row[1]));

/** Largest index i with array[i] <= value (0 if none). */
function floorIndex(array, value, count = array.length) {
  let low = 0;
  let high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (array[middle] <= value) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Value at x of a curve given by two arrays, linear in between. */
function lookUp(xs, ys, x) {
  const n = xs.length;
  if (!n) return null;
  const i = Math.min(floorIndex(xs, x), Math.max(0, n - 2));
  if (n === 1) return ys[0];
  const width = xs[i + 1] - xs[i];
  return width > 0 ? ys[i] + (ys[i + 1] - ys[i]) * clamp((x - xs[i]) / width, 0, 1) : ys[i + 1];
}

function make(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

const SVG = "http:" + "//www.w3.org/2000/svg";

function drawing(tag, attributes, ...children) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

const SIGNS = { good: "M2.5 7.5l3 3 6-7", bad: "M3 3l8 8M11 3l-8 8", warn: "M7 2.5v5.5M7 11v.4", none: "M3 7h8" };
const sign = (kind) => drawing("svg", { viewBox: "0 0 14 14", "aria-hidden": "true" }, drawing("path", { d: SIGNS[kind] }));

/** A number with about four digits that matter. */
function show(value) {
  if (!finite(value)) return "\u2013";
  const size = Math.abs(value) < 5e-7 ? 0 : Math.abs(value);
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 0.1 ? 2 : size >= 0.01 ? 3 : size >= 0.001 ? 4 : null;
  if (size === 0) return "0.00";
  const text = digits === null ? value.toExponential(1) : value.toFixed(digits);
  return text.replace("-", "\u2212");
}

/** A measured number to the millimetre (or its like). */
const exact = (value) => (finite(value) && Math.abs(value) < 1000 && (Math.abs(value) >= 0.001 || value === 0) ? value.toFixed(3).replace("-", "\u2212") : show(value));

/** As `show`, without zeros at the end: for settings rather than measurements. */
const trimmed = (value) => show(value).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
/** A distance to three decimals, never more than it is: a promise is not rounded up. */
const atLeast = (value) => (finite(value) ? exact(Math.floor(value * 1000) / 1000) : show(value));
const percent = (part) => `${(100 * part).toFixed(part === 0 || Math.abs(part) >= 0.00095 ? 1 : Math.abs(part) >= 0.000095 ? 2 : 3).replace("-", "\u2212")} %`;
const words = (key) => String(key).replace(/_/g, " ");
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** Any JSON value as one line of text. */
function plain(value) {
  if (value === null || value === undefined) return "\u2013";
  if (typeof value === "number") return Number.isInteger(value) ? String(value).replace("-", "\u2212") : trimmed(value);
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (Array.isArray(value)) return value.length > 8 ? `${value.length} values` : value.map(plain).join(", ");
  if (typeof value === "object") return Object.entries(value).map(([key, item]) => `${words(key)} ${plain(item)}`).join(", ");
  return String(value);
}

/** A round step of 1, 2 or 5 times a power of ten that is at least `least`. */
function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((k) => k * power).find((step) => step >= least * (1 - 1e-9)) || 10 * power;
}

const metres = (value, step) => value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))).replace("-", "\u2212");

/** Round ticks that cover low..high, at most about `count`. */
function ticksOf(low, high, count) {
  const step = roundStep((high - low) / Math.max(1, count));
  const ticks = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + step * 1e-6; v += step) ticks.push(Math.abs(v) < step * 1e-6 ? 0 : v);
  return { step, ticks };
}

/** Calls `draw` when the width of an element changes; not within the same frame, so that drawing may change its height. */
function onWidth(node, draw) {
  let width = node.clientWidth;
  new ResizeObserver(() => {
    if (node.clientWidth === width) return;
    width = node.clientWidth;
    requestAnimationFrame(draw);
  }).observe(node);
}
