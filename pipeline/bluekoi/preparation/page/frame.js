// A frame of a video with handles to drag, lines drawn over it, and a magnifier.

import { element, numbers, on, store } from "./store.js";

const SVG = "http://www.w3.org/2000/svg";
const ZOOM = 6;
export const chosen = { source: "", share: 0 };

export function svg(name, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

export const line = (points, attributes) => svg("polyline", {
  points: points.filter((p) => p && p[0] !== null).map(([u, v]) => `${u + 0.5},${v + 0.5}`).join(" "), ...attributes });

export class FrameView {
  // more: further words for the address of a row's frame.
  constructor(place, { onPicture = () => {}, more = () => ({}) } = {}) {
    this.onPicture = onPicture;
    this.more = more;
    this.size = [0, 0];
    this.handles = [];
    this.image = element("img", { alt: "Frame of the video", draggable: false });
    this.lines = svg("svg", { preserveAspectRatio: "none", "aria-hidden": "true" });
    this.message = element("p", { className: "message" });
    this.magnifier = element("div", { className: "magnifier", hidden: true });
    this.frame = element("div", { className: "frame" }, this.image, this.lines, this.message, this.magnifier);
    this.select = element("select", { "aria-label": "Video" });
    this.slider = element("input", { type: "range", min: 0, max: 1, step: 1 / 19, value: 0, "aria-label": "Frame" });
    this.time = element("span");
    const bar = element("div", { className: "choose" }, this.select, this.slider, this.time);
    document.getElementById(place).replaceChildren(bar, this.frame);
    this.image.addEventListener("load", () => this.shown());
    this.select.addEventListener("change", () => this.show(this.select.value, chosen.share));
    this.slider.addEventListener("input", () => this.show(chosen.source, Number(this.slider.value)));
  }

  list() {
    const filmed = store.rows.map((row) => row.source).filter((name) => name && !/\.(csv|h5|hdf5|slp)$/i.test(name));
    const names = [...new Set(filmed.length ? filmed : store.files.videos)];
    this.select.replaceChildren(...names.map((name) => element("option", { value: name, textContent: name })));
    if (!names.includes(chosen.source)) chosen.source = names[0] ?? "";
    this.select.value = chosen.source;
    if (!names.length) this.message.textContent = "No video in this folder.";
  }

  async show(source = chosen.source, share = chosen.share) {
    chosen.source = source;
    chosen.share = share;
    this.list();
    this.slider.value = share;
    if (!chosen.source) return;
    const row = store.rows.find((one) => one.source === chosen.source);
    const address = `frame.jpg?${new URLSearchParams({ source: chosen.source, share, fps: row?.fps ?? "",
      ...this.more(row) })}`;
    if (address === this.address) { this.onPicture(); return; }
    this.address = address;
    this.message.textContent = "Reading the video …";
    const answer = await fetch(address).catch(() => null);
    if (this.address !== address) return;
    if (!answer?.ok) {
      this.message.textContent = answer ? await answer.text() : "The server does not answer.";
      this.image.removeAttribute("src");
      return;
    }
    const picture = URL.createObjectURL(await answer.blob());
    if (this.picture) URL.revokeObjectURL(this.picture);
    this.picture = picture;
    this.image.src = picture;
    this.time.textContent = `${Number(answer.headers.get("X-Time")).toFixed(2)} s`;
  }

  shown() {
    this.size = [this.image.naturalWidth, this.image.naturalHeight];
    this.lines.setAttribute("viewBox", `0 0 ${this.size[0]} ${this.size[1]}`);
    this.message.textContent = "";
    this.magnifier.style.backgroundImage = `url(${this.picture})`;
    this.onPicture();
    this.handles.forEach((handle) => this.place(handle));
  }

  // Pixels of study.yaml in one pixel of this frame: the frame may be the same picture, scaled.
  scale() {
    const stated = numbers(store.values["camera.image_size_px"] ?? "");
    return stated && this.size[0] ? this.size[0] / stated[0] : 1;
  }

  toFrame([u, v]) { const s = this.scale(); return [u * s + (s - 1) / 2, v * s + (s - 1) / 2]; }

  toStudy([u, v]) { const s = this.scale(); return [(u - (s - 1) / 2) / s, (v - (s - 1) / 2) / s]; }

  draw(...parts) {
    this.lines.replaceChildren(...parts.flat());
    if (!this.magnifier.hidden) this.magnify(this.magnified);
  }

  // A button over the frame that stands for a point in frame pixels, moved by pointer or arrow keys.
  handle(label, at, { square = false, moved, ended }) {
    const button = element("button", { className: `handle${square ? " square" : ""}`, "aria-label": label });
    button.dataset.label = label;
    const handle = { button, at };
    const move = (u, v) => {
      handle.at = [Math.min(Math.max(u, -0.2 * this.size[0]), 1.2 * this.size[0]),
        Math.min(Math.max(v, -0.2 * this.size[1]), 1.2 * this.size[1])];
      this.place(handle);
      moved(handle.at);
      this.magnify(handle);
    };
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      const from = [event.clientX, event.clientY], start = handle.at;
      const per = this.size[0] / this.frame.clientWidth;
      const follow = (e) => move(start[0] + (e.clientX - from[0]) * per, start[1] + (e.clientY - from[1]) * per);
      button.addEventListener("pointermove", follow);
      const end = () => {
        button.removeEventListener("pointermove", follow);
        ended(handle.at);
      };
      button.addEventListener("pointerup", end, { once: true });
      this.magnify(handle);
    });
    let waiting;
    button.addEventListener("keydown", (event) => {
      const [du, dv] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] ?? [0, 0];
      if (!du && !dv) return;
      event.preventDefault();
      const step = event.shiftKey ? 10 : event.altKey ? 0.1 : 1;
      move(handle.at[0] + du * step, handle.at[1] + dv * step);
      clearTimeout(waiting);
      waiting = setTimeout(() => ended(handle.at), 400);
    });
    button.addEventListener("focus", () => this.magnify(handle));
    button.addEventListener("blur", () => { this.magnifier.hidden = true; });
    this.frame.addEventListener("pointerleave", ({ buttons }) => { if (!buttons) this.magnifier.hidden = true; });
    this.frame.append(button);
    this.handles.push(handle);
    this.place(handle);
    return { ...handle, set: (point) => { handle.at = point; this.place(handle); }, get point() { return handle.at; } };
  }

  place({ button, at }) {
    if (!this.size[0]) { button.hidden = true; return; }
    button.hidden = false;
    const share = [(at[0] + 0.5) / this.size[0], (at[1] + 0.5) / this.size[1]];
    button.style.left = `${100 * share[0]}%`;
    button.style.top = `${100 * share[1]}%`;
    button.classList.toggle("at-right", share[0] > 0.8);
    button.classList.toggle("at-top", share[1] < 0.1);
  }

  // In the middle of the frame, or beside it for a point there: never over another corner.
  magnify(handle) {
    const box = this.magnifier, { at } = handle;
    this.magnified = handle;
    box.hidden = false;
    const width = box.clientWidth, per = this.frame.clientWidth / this.size[0];
    const near = at.every((x, k) => Math.abs(x - this.size[k] / 2) * per < 0.9 * width);
    box.classList.toggle("at-right", near && at[0] < 0.5 * this.size[0]);
    box.classList.toggle("at-left", near && at[0] >= 0.5 * this.size[0]);
    box.style.backgroundSize = `${this.size[0] * ZOOM}px ${this.size[1] * ZOOM}px`;
    const place = (k) => width / 2 - (at[k] + 0.5) * ZOOM;
    box.style.backgroundPosition = `${place(0)}px ${place(1)}px`;
    const copy = this.lines.cloneNode(true);
    const seen = width / ZOOM;
    copy.setAttribute("viewBox", `${at[0] + 0.5 - seen / 2} ${at[1] + 0.5 - seen / 2} ${seen} ${seen}`);
    const cross = svg("svg", { viewBox: "0 0 100 100" });
    cross.append(svg("path", { d: "M0 50H42M58 50H100M50 0V42M50 58V100", stroke: "#ff3c3c", "stroke-width": 1 }));
    box.replaceChildren(copy, cross);
  }
}

on("reload", () => { if (!store.rows.some((row) => row.source === chosen.source)) chosen.source = ""; });
