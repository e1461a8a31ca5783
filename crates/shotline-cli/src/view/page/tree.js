// The scene graph: opened node by node; objects can be hidden, or shown alone.

const KINDS = { union: "∪ union", intersection: "∩ intersection", difference: "∖ difference" };

function nodeRow(node) {
  const row = document.createElement("div");
  row.setAttribute("role", "treeitem");
  const line = document.createElement("div");
  line.className = "node";
  row.append(line);
  const opener = document.createElement("button");
  opener.className = "open";
  opener.textContent = node.children ? "▸" : "";
  opener.disabled = !node.children;
  opener.setAttribute("aria-label", "Open");
  line.append(opener);
  if (node.color) {
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = `rgb(${node.color.map((c) => Math.round(c * 255)).join(" ")})`;
    line.append(swatch);
  }
  const what = document.createElement("span");
  what.className = "what";
  const name = node.label || node.name;
  what.textContent = name ?? KINDS[node.kind] ?? node.kind;
  what.title = [node.kind, node.name, node.material].filter(Boolean).join(" · ");
  line.append(what);
  if (node.kind === "object") addObjectButtons(line, node.name);
  let below = null;
  opener.addEventListener("click", async () => {
    if (below) {
      below.hidden = !below.hidden;
    } else {
      below = document.createElement("div");
      below.className = "below";
      below.setAttribute("role", "group");
      row.append(below);
      await fillNodes(below, node.id);
    }
    opener.textContent = below.hidden ? "▸" : "▾";
    row.setAttribute("aria-expanded", String(!below.hidden));
  });
  return row;
}

function addObjectButtons(line, name) {
  line.dataset.object = name;
  const hide = document.createElement("button");
  hide.className = "hide";
  hide.addEventListener("click", () => {
    state.only = null;
    if (state.hidden.has(name)) state.hidden.delete(name);
    else state.hidden.add(name);
    changed();
  });
  const alone = document.createElement("button");
  alone.className = "alone";
  alone.textContent = "only";
  alone.addEventListener("click", () => {
    state.only = state.only === name ? null : name;
    changed();
  });
  line.append(hide, alone);
  markObject(line);
}

function markObject(line) {
  const name = line.dataset.object;
  const isHidden = state.only ? state.only !== name : state.hidden.has(name);
  line.classList.toggle("is-hidden", isHidden);
  line.querySelector(".hide").textContent = state.hidden.has(name) ? "show" : "hide";
  line.querySelector(".hide").setAttribute("aria-label", `${state.hidden.has(name) ? "Show" : "Hide"} ${name}`);
  line.querySelector(".alone").setAttribute("aria-pressed", String(state.only === name));
  line.querySelector(".alone").setAttribute("aria-label", `Show ${name} alone`);
}

function markObjects() {
  document.querySelectorAll("#tree [data-object]").forEach(markObject);
  const chosen = state.only ? `only ${state.only} is shown` : state.hidden.size ? `${state.hidden.size} hidden` : "";
  byId("chosen").hidden = !chosen;
  byId("chosen-text").textContent = chosen;
}

// Appends the nodes below a node, 200 at a time.
async function fillNodes(parent, of, from = 0) {
  const { head } = await connection.ask({ ask: "children", of, from });
  const { nodes, count } = head.answer;
  parent.append(...nodes.map(nodeRow));
  const reached = from + nodes.length;
  if (reached < count) {
    const more = document.createElement("button");
    more.className = "more";
    more.textContent = `${count - reached} more`;
    more.addEventListener("click", () => { more.remove(); fillNodes(parent, of, reached); });
    parent.append(more);
  }
}

async function fillTree() {
  const text = byId("search").value.trim();
  const tree = byId("tree");
  const asked = (fillTree.asked = {});
  if (!text) {
    const roots = document.createElement("div");
    await fillNodes(roots, null);
    if (fillTree.asked === asked) tree.replaceChildren(roots);
    return;
  }
  const { head } = await connection.ask({ ask: "find", text });
  if (fillTree.asked !== asked) return;
  const { nodes, count } = head.answer;
  const note = document.createElement("div");
  note.className = "kind";
  note.textContent = count > nodes.length ? `the first ${nodes.length} of ${count}` : count ? "" : "no object has such a name";
  tree.replaceChildren(...nodes.map(nodeRow), note);
}
