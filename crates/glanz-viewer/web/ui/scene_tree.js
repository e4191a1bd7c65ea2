/**
 * The tree of parts. Only the rows in sight are elements, so that scenes with a hundred thousand shapes scroll; the focus stays on the tree, which says which row
 * is the active one.
 *
 * @module
 */

import { create, element } from "./dom.js";

/** @typedef {import("../scene_parts.js").SceneParts} SceneParts */
/** @typedef {import("../scene_parts.js").Item} Item */

/** Trees with more leaves than this have a search field. */
const SEARCHED = 20;

/** Rows drawn above and below those in sight. */
const SPARE = 8;

/** ARIA names of the states. */
const CHECKED = { shown: "true", hidden: "false", mixed: "mixed" };

export class SceneTree {
  /** @param {{ selected(item: Item): void, visibility(): void }} listener told what the user does to the parts */
  constructor(listener) {
    this.listener = listener;
    this.container = element("tree", HTMLElement);
    this.search = element("search", HTMLInputElement);
    /** @type {SceneParts | null} */
    this.parts = null;
    /** @type {Item[]} */
    this.rows = [];
    /** @type {Item | null} */
    this.active = null;
    this.rowHeight = 0;
    this.list = create("div", "", "rows");
    this.list.setAttribute("role", "presentation");
    this.container.append(this.list);
    this.container.addEventListener("scroll", () => this.render());
    this.container.addEventListener("keydown", (event) => this.press(event));
    this.list.addEventListener("click", (event) => this.click(event));
    this.search.addEventListener("input", () => this.refresh());
    new ResizeObserver(() => this.render()).observe(this.container);
  }

  /** @param {SceneParts} parts */
  set(parts) {
    this.parts = parts;
    this.active = null;
    this.search.value = "";
    this.search.hidden = parts.count <= SEARCHED;
    this.refresh();
  }

  /** Shows the parts as they are now. */
  refresh() {
    this.rows = this.parts?.rows(this.search.hidden ? "" : this.search.value) ?? [];
    this.render();
  }

  /** Makes the selected part the active row, and brings it into sight. */
  reveal() {
    this.refresh();
    if (this.parts?.selected) this.activate(this.parts.selected);
  }

  /** @param {Item} item */
  activate(item) {
    this.active = item;
    const index = this.rows.indexOf(item);
    if (index >= 0 && this.rowHeight > 0) {
      const [top, bottom] = [index * this.rowHeight, (index + 1) * this.rowHeight];
      const { scrollTop, clientHeight } = this.container;
      if (top < scrollTop) this.container.scrollTop = top;
      else if (bottom > scrollTop + clientHeight) this.container.scrollTop = bottom - clientHeight;
    }
    this.render();
  }

  render() {
    if (this.rowHeight === 0 && this.rows.length > 0) {
      this.list.replaceChildren(this.row(this.rows[0], 0));
      this.rowHeight = this.list.firstElementChild?.getBoundingClientRect().height ?? 0;
    }
    this.list.style.height = `${this.rows.length * this.rowHeight}px`;
    if (this.rowHeight === 0) return;
    const { scrollTop, clientHeight } = this.container;
    const first = Math.max(0, Math.floor(scrollTop / this.rowHeight) - SPARE);
    const end = Math.min(this.rows.length, Math.ceil((scrollTop + clientHeight) / this.rowHeight) + SPARE);
    this.list.replaceChildren(...this.rows.slice(first, end).map((item, i) => this.row(item, first + i)));
    const active = this.active ? this.rows.indexOf(this.active) : -1;
    if (active >= first && active < end) this.container.setAttribute("aria-activedescendant", `row-${active}`);
    else this.container.removeAttribute("aria-activedescendant");
  }

  /**
   * @param {Item} item
   * @param {number} index
   */
  row(item, index) {
    const row = create("div", "", "row");
    row.id = `row-${index}`;
    row.dataset["index"] = String(index);
    row.style.top = `${index * this.rowHeight}px`;
    const searching = this.search.value !== "" && !this.search.hidden;
    row.style.setProperty("--level", String(searching ? 1 : item.level));
    const visibility = this.parts?.visibility(item) ?? "shown";
    row.setAttribute("role", "treeitem");
    row.setAttribute("aria-level", String(item.level));
    row.setAttribute("aria-setsize", String(item.parent?.children.length ?? 1));
    row.setAttribute("aria-posinset", String(item.position));
    row.setAttribute("aria-checked", CHECKED[visibility]);
    row.setAttribute("aria-selected", String(item === this.parts?.selected));
    const foldable = item.children.length > 0 && !searching;
    if (foldable) row.setAttribute("aria-expanded", String(item.expanded));
    row.classList.toggle("active", item === this.active);
    row.append(create("span", foldable ? (item.expanded ? "▾" : "▸") : "", "fold"), create("span", "", "check"));
    row.append(create("span", item.label, "label"));
    const what = item.node.kind === "group" ? `${item.end - item.first}` : (item.node.what ?? "");
    row.append(create("span", what === item.label ? "" : what, "what"));
    row.title = item.node.place ?? "";
    return row;
  }

  /** @param {MouseEvent} event */
  click(event) {
    const target = event.target instanceof Element ? event.target : null;
    const row = target?.closest(".row");
    const item = row instanceof HTMLElement ? this.rows[Number(row.dataset["index"])] : undefined;
    if (!item || !target) return;
    if (target.classList.contains("check")) this.toggleVisibility(item);
    else if (target.classList.contains("fold") && item.children.length > 0) this.fold(item, !item.expanded);
    else this.listener.selected(item);
    this.activate(item);
  }

  /** @param {Item} item */
  toggleVisibility(item) {
    this.parts?.show(item, this.parts.visibility(item) !== "shown");
    this.listener.visibility();
  }

  /**
   * @param {Item} item
   * @param {boolean} expanded
   */
  fold(item, expanded) {
    item.expanded = expanded;
    this.refresh();
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const index = this.active ? this.rows.indexOf(this.active) : -1;
    const page = Math.max(1, Math.floor(this.container.clientHeight / (this.rowHeight || 1)) - 1);
    /** @type {Record<string, number>} */
    const targets = {
      ArrowDown: index + 1,
      ArrowUp: index - 1,
      PageDown: index + page,
      PageUp: index - page,
      Home: 0,
      End: this.rows.length - 1,
    };
    const target = targets[event.key];
    if (target !== undefined) {
      const item = this.rows[Math.min(this.rows.length - 1, Math.max(0, target))];
      if (item) this.activate(item);
    } else if (!this.act(event.key)) {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  /**
   * What a key does to the active row; whether it does anything.
   * @param {string} key
   */
  act(key) {
    const item = this.active;
    if (!item) return false;
    if (key === "Enter") this.listener.selected(item);
    else if (key === " ") this.toggleVisibility(item);
    else if (key === "ArrowRight") this.unfoldOrEnter(item);
    else if (key === "ArrowLeft") this.foldOrLeave(item);
    else return false;
    return true;
  }

  /** @param {Item} item */
  unfoldOrEnter(item) {
    if (item.children.length === 0) return;
    if (!item.expanded) this.fold(item, true);
    else this.activate(item.children[0]);
  }

  /** @param {Item} item */
  foldOrLeave(item) {
    if (item.children.length > 0 && item.expanded) this.fold(item, false);
    else if (item.parent) this.activate(item.parent);
  }
}
