/** The object dictionary of a node, read and written by SDO. */

import { useState } from "react";
import type { Bus, ObjectEntry } from "./protocol/Ui.ts";
import { store } from "./store.ts";

const SHOWN = 100;

const number = (entry: ObjectEntry): string => `${entry.index.toString(16).toUpperCase()}h:${entry.subindex}`;

export function Objects({ bus, full }: { bus: Bus; full: boolean }) {
  const [nodeId, choose] = useState(0);
  const [entries, list] = useState<readonly ObjectEntry[]>([]);
  const [filter, setFilter] = useState("");
  const [values, setValues] = useState<ReadonlyMap<string, string>>(new Map());
  const [edited, edit] = useState<ReadonlyMap<string, string>>(new Map());
  const open = async (node_id: number) => {
    choose(node_id);
    setValues(new Map());
    edit(new Map());
    const result = node_id ? await store.order({ case: "node", value: { bus: bus.name, node_id } }) : undefined;
    list(result?.done ? result.objects : []);
  };
  const access = (entry: ObjectEntry, text: string) => ({ bus: bus.name, node_id: nodeId, index: entry.index, subindex: entry.subindex, text });
  const read = async (entry: ObjectEntry) => {
    const result = await store.order({ case: "read", value: access(entry, "") });
    if (result.done) setValues((before) => new Map(before).set(number(entry), result.text));
  };
  const write = async (entry: ObjectEntry) => {
    const result = await store.order({ case: "written", value: access(entry, edited.get(number(entry)) ?? "") });
    if (result.done && entry.access !== "wo") await read(entry);
  };
  const wanted = filter.toLowerCase();
  const shown = entries.filter((each) => `${number(each)} ${each.name}`.toLowerCase().includes(wanted)).slice(0, SHOWN);
  return (
    <section aria-label="Object dictionary">
      <h2>Object dictionary</h2>
      <label>
        Node
        <select value={nodeId} onChange={(e) => void open(Number(e.target.value))}>
          <option value={0}>none</option>
          {bus.nodes.map((each) => (
            <option key={each.node_id} value={each.node_id}>
              {each.name}
            </option>
          ))}
        </select>
      </label>{" "}
      <label>
        Objects
        <input value={filter} placeholder="6083 or a name" onChange={(e) => setFilter(e.target.value)} />
      </label>
      {nodeId > 0 && (
        <div className="rows" tabIndex={0}>
          <table aria-label="Entries">
            <tbody>
              {shown.map((entry) => {
                const key = number(entry);
                const constant = entry.access === "ro" || entry.access === "const";
                return (
                  <tr key={key}>
                    <th scope="row">
                      {key} <bdi>{entry.name}</bdi>
                    </th>
                    <td className="text">
                      <bdi>{entry.type}</bdi>, <bdi>{entry.access}</bdi>
                    </td>
                    <td className="text">
                      {entry.access !== "wo" && (
                        <button type="button" disabled={!full} aria-label={`Read ${key}`} onClick={() => void read(entry)}>
                          Read
                        </button>
                      )}{" "}
                      <output aria-label={`Value of ${key}`}>{values.get(key)}</output>
                    </td>
                    <td>
                      {!constant && (
                        <form
                          onSubmit={(e) => {
                            e.preventDefault();
                            void write(entry);
                          }}
                        >
                          <input size={9} aria-label={`New value of ${key}`} disabled={!full} value={edited.get(key) ?? ""} onChange={(e) => edit(new Map(edited).set(key, e.target.value))} />
                          <button type="submit" disabled={!full} aria-label={`Write ${key}`}>
                            Write
                          </button>
                        </form>
                      )}
                    </td>
                  </tr>
                );
              })}
            </tbody>
          </table>
        </div>
      )}
      {nodeId > 0 && !entries.length && <p>No description of this node is known.</p>}
    </section>
  );
}
