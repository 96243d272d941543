// Map images: small palette PNGs whose palette is rewritten for the theme, with reduced copies for far views.

const crcTable = Int32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; k += 1) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

function crc(bytes, from, to) {
  let c = -1;
  for (let i = from; i < to; i += 1) c = crcTable[(c ^ bytes[i]) & 255] ^ (c >>> 8);
  return ~c >>> 0;
}

/** Bytes of a palette PNG with other colours ([[r, g, b], ...]) in its PLTE chunk. */
function recolour(base64, colours) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  for (let at = 8; at + 12 <= bytes.length; at += 12 + view.getUint32(at)) {
    const size = view.getUint32(at);
    if (view.getUint32(at + 4) !== 0x504c5445) continue;
    colours.slice(0, size / 3).forEach((colour, i) => bytes.set(colour, at + 8 + 3 * i));
    view.setUint32(at + 8 + size, crc(bytes, at + 4, at + 8 + size));
    break;
  }
  return bytes;
}

const rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
const blend = (a, b, part) => a.map((v, i) => Math.round(v + (b[i] - v) * part));

/** Decodes an image and halves it until it is small; resolves to the levels, finest first. */
async function loadLevels(entry, colours) {
  const bitmap = await createImageBitmap(new Blob([recolour(entry.png, colours)], { type: "image/png" }));
  const levels = [{ image: bitmap, width: bitmap.width, height: bitmap.height }];
  let last = levels[0];
  while (Math.max(last.width, last.height) > 700) {
    const canvas = document.createElement("canvas");
    canvas.width = Math.ceil(last.width / 2);
    canvas.height = Math.ceil(last.height / 2);
    const pen = canvas.getContext("2d");
    pen.imageSmoothingQuality = "high";
    pen.drawImage(last.image, 0, 0, last.width, last.height, 0, 0, last.width / 2, last.height / 2);
    last = { image: canvas, width: last.width / 2, height: last.height / 2 };
    levels.push(last);
  }
  return levels;
}

/** The images of a world in the colours of the theme. */
async function loadWorld(world, colour) {
  const shades = Array.from({ length: 64 }, (_, i) => blend(rgb(colour.near), rgb(colour.far), i / 63));
  const [wallLevels, shadeLevels] = await Promise.all([
    world.walls ? loadLevels(world.walls, [rgb(colour.far), rgb(colour.wall), rgb(colour.unknown), rgb(colour.forbidden)]) : null,
    world.shade ? loadLevels(world.shade, shades) : null,
  ]);
  return { wallLevels, shadeLevels };
}

/** Draws the visible part of an image into the map frame; `view` maps metres to pixels, `crisp` keeps cells square when they are large. */
function drawRaster(pen, view, world, entry, levels, crisp) {
  const [x0, y0, yaw] = world.origin;
  const perPixel = entry.cell * view.scale;
  const level = Math.min(levels.length - 1, Math.max(0, Math.floor(Math.log2(1 / (perPixel * view.ratio)) + 0.35)));
  const { image, width, height } = levels[level];
  const size = (entry.cell * entry.width) / width;
  const visible = visiblePart(view, world.origin, entry.top, size, width, height);
  if (!visible) return;
  const [left, top, w, h] = visible;
  pen.save();
  pen.translate(view.x(x0), view.y(y0));
  pen.rotate(-yaw);
  pen.beginPath();
  pen.rect(0, -entry.top * view.scale, entry.span * view.scale, entry.top * view.scale);
  pen.clip();
  pen.imageSmoothingEnabled = !(crisp && perPixel * view.ratio > 1.3);
  pen.imageSmoothingQuality = "medium";
  const k = size * view.scale;
  const place = [left * k, top * k - entry.top * view.scale, w * k, h * k];
  pen.drawImage(image, left, top, w, h, ...place);
  if (crisp && level > 0) pen.drawImage(image, left, top, w, h, ...place);
  pen.restore();
}

/** Part of an image that the view shows, in its pixels: [left, top, width, height], or null. */
function visiblePart(view, [x0, y0, yaw], top, size, width, height) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  const corners = [[0, 0], [view.width, 0], [view.width, view.height], [0, view.height]].map(([px, py]) => {
    const [dx, dy] = [view.worldX(px) - x0, view.worldY(py) - y0];
    return [(cos * dx + sin * dy) / size, (top - (cos * dy - sin * dx)) / size];
  });
  const left = Math.max(0, Math.floor(Math.min(...corners.map((c) => c[0]))) - 1);
  const upper = Math.max(0, Math.floor(Math.min(...corners.map((c) => c[1]))) - 1);
  const right = Math.min(width, Math.ceil(Math.max(...corners.map((c) => c[0]))) + 1);
  const lower = Math.min(height, Math.ceil(Math.max(...corners.map((c) => c[1]))) + 1);
  return right > left && lower > upper ? [left, upper, right - left, lower - upper] : null;
}
