// Functions that the scripts of all pages share: elements, packed numbers, canvases. No library, no network.
function element(name, attributes, parent, text) {
  const made = document.createElement(name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}
function bytes(text) { return Uint8Array.from(atob(text), character => character.charCodeAt(0)).buffer; }
function words(text, signed) {
  const view = new DataView(bytes(text)), made = new (signed ? Int16Array : Uint16Array)(view.byteLength / 2);
  return made.map((_, i) => signed ? view.getInt16(2 * i, true) : view.getUint16(2 * i, true));
}
// Largest of 1, 2 and 5 times a power of ten that is not above `most`; the same as largest_round_number in style.py.
function roundNumber(most) {
  const power = 10 ** Math.floor(Math.log10(most) + 1e-10);
  return power * [5, 2, 1].find(digit => digit * power <= most * (1 + 1e-9));
}
// Empties a canvas and sets its size in screen pixels: the width of its parent, and `ratio` times this as height.
function surface(canvas, ratio) {
  const density = window.devicePixelRatio || 1, width = canvas.clientWidth || 300, height = Math.round(width * ratio);
  canvas.style.height = height + "px";
  if (canvas.width !== Math.round(width * density) || canvas.height !== Math.round(height * density)) {
    canvas.width = Math.round(width * density);
    canvas.height = Math.round(height * density);
  }
  const context = canvas.getContext("2d");
  context.setTransform(density, 0, 0, density, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = (width < 180 ? 9 : 12) + "px system-ui, sans-serif";
  return { context, width, height };
}
