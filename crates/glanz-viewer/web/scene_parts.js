/**
 * The parts of a scene: its tree as a list, what is hidden, what is selected.
 *
 * @module
 */

/** @typedef {import("./model.js").TreeNode} TreeNode */

/**
 * A node of the tree. Its leaves are numbered from `first` up to, not including, `end`: leaves are numbered in the order of the tree.
 * @typedef {{ node: TreeNode, label: string, level: number, parent: Item | null, children: Item[], position: number, first: number,
 *   end: number, expanded: boolean }} Item
 */

/** Groups with more children than this are folded at first. */
const UNFOLDED = 40;

/** Most rows that a search shows. */
const MOST_MATCHES = 500;

export class SceneParts {
  /** @param {TreeNode} tree */
  constructor(tree) {
    this.count = 0;
    this.root = this.read(tree, null, 1, 1);
    /** @type {Set<number>} */
    this.hidden = new Set();
    /** Hidden leaves before a part was isolated. @type {Set<number> | null} */
    this.beforeIsolation = null;
    /** @type {Item | null} */
    this.selected = null;
  }

  /**
   * @param {TreeNode} node
   * @param {Item | null} parent
   * @param {number} level
   * @param {number} position among its siblings, from 1
   * @returns {Item}
   */
  read(node, parent, level, position) {
    const children = node.children ?? [];
    /** @type {Item} */
    const item = {
      node,
      label: node.name || node.what || (node.kind === "group" ? "group" : "shape"),
      level,
      parent,
      children: [],
      position,
      first: this.count,
      end: this.count,
      expanded: level === 1 || children.length <= UNFOLDED,
    };
    if (node.kind === "shape") {
      this.count += 1;
    }
    item.children = children.map((child, i) => this.read(child, item, level + 1, i + 1));
    item.end = this.count;
    return item;
  }

  /**
   * The rows to show, from top to bottom: everything in unfolded groups, or what matches a search.
   * @param {string} search
   * @returns {Item[]}
   */
  rows(search = "") {
    const wanted = search.trim().toLowerCase();
    /** @type {Item[]} */
    const rows = [];
    /** @param {Item} item */
    const walk = (item) => {
      if (rows.length >= MOST_MATCHES && wanted) return;
      if (!wanted || matches(item, wanted)) rows.push(item);
      if (wanted || item.expanded) item.children.forEach(walk);
    };
    walk(this.root);
    return rows;
  }

  /**
   * The shape of a leaf, `null` if there is none of this number.
   * @param {number} leaf
   * @returns {Item | null}
   */
  shape(leaf) {
    let item = this.root;
    if (!(leaf >= item.first && leaf < item.end)) return null;
    while (item.node.kind !== "shape") {
      const next = item.children.find((child) => leaf >= child.first && leaf < child.end);
      if (!next) return null;
      item = next;
    }
    return item;
  }

  /**
   * @param {Item} item
   * @returns {"shown" | "hidden" | "mixed"}
   */
  visibility(item) {
    let hidden = 0;
    for (let leaf = item.first; leaf < item.end; leaf++) hidden += this.hidden.has(leaf) ? 1 : 0;
    if (hidden === 0) return "shown";
    return hidden === item.end - item.first ? "hidden" : "mixed";
  }

  /**
   * @param {Item} item
   * @param {boolean} shown
   */
  show(item, shown) {
    for (let leaf = item.first; leaf < item.end; leaf++) {
      if (shown) this.hidden.delete(leaf);
      else this.hidden.add(leaf);
    }
    this.beforeIsolation = null;
  }

  showAll() {
    this.hidden.clear();
    this.beforeIsolation = null;
  }

  /**
   * Isolates a part; the second call restores the visibility before.
   * @param {Item} item
   */
  isolate(item) {
    if (this.beforeIsolation) {
      this.hidden = this.beforeIsolation;
      this.beforeIsolation = null;
      return;
    }
    this.beforeIsolation = this.hidden;
    this.hidden = new Set();
    for (let leaf = 0; leaf < this.count; leaf++) {
      if (leaf < item.first || leaf >= item.end) this.hidden.add(leaf);
    }
  }

  /** The selected shape's leaf, `null` for groups. */
  get selectedLeaf() {
    return this.selected?.node.kind === "shape" ? this.selected.first : null;
  }

  /**
   * Selects a part and unfolds what it is in.
   * @param {Item | null} item
   */
  select(item) {
    this.selected = item;
    for (let group = item?.parent ?? null; group; group = group.parent) group.expanded = true;
  }

  /**
   * Takes over what is hidden, selected and folded from an earlier state of the same scene, as far as the leaves agree.
   * @param {SceneParts} before
   */
  inherit(before) {
    if (before.count !== this.count) return;
    this.hidden = before.hidden;
    const leaf = before.selectedLeaf;
    if (leaf !== null) this.select(this.shape(leaf));
  }
}

/**
 * @param {Item} item
 * @param {string} wanted in lower case
 */
function matches(item, wanted) {
  const { node } = item;
  return [item.label, node.what, node.place].some((text) => text?.toLowerCase().includes(wanted));
}

/**
 * Leaves as the server reads them: runs of several as first and last, so that a message about very many is short.
 * @param {Set<number>} leaves
 * @returns {(number | [first: number, last: number])[]} ascending
 */
export function ranges(leaves) {
  /** @type {[number, number][]} */
  const runs = [];
  for (const leaf of [...leaves].sort((a, b) => a - b)) {
    const run = runs.at(-1);
    if (run && run[1] === leaf - 1) run[1] = leaf;
    else runs.push([leaf, leaf]);
  }
  return runs.map(([first, last]) => (first === last ? first : [first, last]));
}
