/** Panes of views that are split, exchanged, resized and remembered; the first one is the main pane. */

import { ArrowLeftRight, ChevronDown, EllipsisVertical } from "lucide-react";
import type { KeyboardEvent, ReactNode, RefObject } from "react";
import { createContext, useContext, useLayoutEffect, useMemo, useRef, useState } from "react";
import { Separator, Workspace as Panes, useParentTabsetState, useParentWorkspace, useTabListOverflow } from "react-resizable-panels";
import type { HiddenTabBehavior, Orientation, TabNode, TabRenderProps, TabsetNode, WorkspaceImperativeHandle } from "react-resizable-panels";
import { Button, IconButton } from "./kit/Button.tsx";
import { Menu } from "./Menu.tsx";
import type { Item, Place } from "./Menu.tsx";
import { t } from "./texts.ts";
import type { Tree, View } from "./views.ts";
import { VIEWS, exchanged, isOfComponent, panes, tabOf, titleOf, written } from "./views.ts";

type Handle = WorkspaceImperativeHandle<View>;

/** What the rest of the page asks of its panes. */
export class Arranger {
  constructor(private readonly handle: RefObject<Handle | null>) {}

  private get panes(): TabsetNode<View>[] {
    return this.handle.current ? panes(this.handle.current.getModel().root) : [];
  }

  has(view: View): boolean {
    return this.panes.some((each) => each.tabs.some(({ id }) => id === view));
  }

  /** Shows a view where it is, else beside the views of components. */
  open(view: View): void {
    if (this.has(view)) this.handle.current?.selectTab(view);
    else this.add(view, true);
  }

  add(view: View, select = false): void {
    const handle = this.handle.current;
    if (!handle || this.has(view)) return;
    if (view === "Palette") handle.addTab(tabOf(view), { target: { edge: "left" }, size: "260px" });
    else {
      const beside = this.panes.find((each) => each.tabs.some(({ data }) => isOfComponent(data))) ?? this.panes.at(-1)!;
      handle.addTab(tabOf(view), { tabsetId: beside.id, select });
    }
  }

  close(view: View): void {
    if (this.has(view)) this.handle.current?.closeTab(view);
  }

  /** Whether a pane has this view alone. */
  isAlone(view: View): boolean {
    return this.panes.some((each) => each.tabs.length === 1 && each.tabs[0]!.id === view);
  }

  /** Whether a view of components is shown. */
  get showsComponent(): boolean {
    return this.panes.some((each) => isOfComponent((each.selectedId ?? each.tabs[0]?.id) as View));
  }

  arrange(root: Tree): void {
    this.handle.current?.setModel({ version: 1, root });
  }
}

/** Draws a view. In a context, since the panes need not be drawn again when what they show changes. */
const Content = createContext<(view: View) => ReactNode>(() => null);

function Shown({ view }: { view: View }) {
  return useContext(Content)(view);
}

const renderContent = ({ data }: TabNode<View>) => <Shown view={data} />;

/** Why views have nothing to show; a reference, for the same reason. */
const Emptiness = createContext<RefObject<(view: View) => string>>({ current: () => "" });

function Tab({ tab, props }: { tab: TabNode<View>; props: TabRenderProps }) {
  const handle = useParentWorkspace<View>();
  return (
    <div
      {...props}
      data-group={isOfComponent(tab.data) ? "component" : "system"}
      onKeyDown={(e: KeyboardEvent<HTMLElement>) => {
        // Delete is for what is selected in the wiring; views are closed by the menu of their pane.
        if (e.key === "Delete" || e.key === "Backspace") return;
        props.onKeyDown?.(e);
        const reached = (document.activeElement as HTMLElement | null)?.dataset["tabId"];
        if (reached && reached !== tab.id) handle?.selectTab(reached);
      }}
    >
      {tab.title}
    </div>
  );
}

const renderTab = (tab: TabNode<View>, props: TabRenderProps) => <Tab tab={tab} props={props} />;

const renderSeparator = (orientation: Orientation) => <Separator className={`grip ${orientation}`} aria-label={orientation === "horizontal" ? t("Width of the panes") : t("Height of the panes")} />;

/** The buttons of a pane, which do by keyboard what dragging its tabs does by mouse. */
function Toolbar({ tabset }: { tabset: TabsetNode<View> }) {
  const handle = useParentWorkspace<View>();
  const state = useParentTabsetState();
  const emptiness = useContext(Emptiness);
  const covered = useTabListOverflow({ includePartiallyVisible: true }) as View[];
  const [menu, show] = useState<Place & { items: readonly Item[] }>();
  const chosen = tabset.selectedId ?? tabset.tabs[0]?.id;
  const button = useRef<HTMLButtonElement>(null);
  // The button that comes beside the tabs may cover the one that is shown.
  useLayoutEffect(() => {
    const header = button.current?.closest("[data-tabset-header]");
    header?.querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }, [chosen, covered.length > 0]);
  if (!handle || !state) return null;
  const view = chosen as View | undefined;
  if (!view) return null;
  const open = (button: Element, label: string, items: readonly Item[]) => {
    const { left, bottom } = button.getBoundingClientRect();
    show({ label, x: left, y: bottom, items });
  };
  const begins = (each: View, i: number, all: readonly View[]) => i === 0 || isOfComponent(each) !== isOfComponent(all[i - 1]!);
  const deeds = (): Item[] => {
    const { root } = handle.getModel();
    const all = panes(root);
    const opened = all.flatMap((each) => each.tabs.map(({ data }) => data));
    const put = (other: View) =>
      opened.includes(other) ? handle.moveTab(other, { tabsetId: tabset.id, region: "center" }) : handle.addTab(tabOf(other), { tabsetId: tabset.id });
    const move = (region: "right" | "bottom") => handle.moveTab(view, { tabsetId: tabset.id, region });
    return [
      ...(tabset.tabs.length > 1
        ? [
            { name: t("{view} beside the others", { view: titleOf(view) }), act: () => move("right") },
            { name: t("{view} below the others", { view: titleOf(view) }), act: () => move("bottom") },
          ]
        : []),
      ...(state.isRoot ? [] : [state.isMaximized ? { name: t("All panes"), act: () => handle.restoreTabset() } : { name: t("This pane alone"), act: () => handle.maximizeTabset(tabset.id) }]),
      ...(opened.length > 1 ? [{ name: t("Close {view}", { view: titleOf(view) }), act: () => handle.closeTab(view) }] : []),
      ...VIEWS.filter((each) => !tabset.tabs.some(({ id }) => id === each)).map((each, i, all) => ({
        name: t("Show {view} here", { view: titleOf(each) }),
        act: () => void put(each),
        obstacle: emptiness.current(each),
        begins: begins(each, i, all),
      })),
    ];
  };
  const isMain = panes(handle.getModel().root)[0]?.id === tabset.id;
  return (
    <>
      {covered.length > 0 && (
        <Button
          ref={button}
          look="plain"
          aria-haspopup="menu"
          aria-label={t("More views")}
          onClick={(e) => open(e.currentTarget, t("More views"), covered.map((each, i) => ({ name: titleOf(each), act: () => handle.selectTab(each), begins: i > 0 && begins(each, i, covered) })))}
        >
          {t("More")}
          <ChevronDown size={16} aria-hidden />
        </Button>
      )}
      {!isMain && (
        <IconButton icon={ArrowLeftRight} look="plain" label={t("Exchange {view} with the main pane", { view: titleOf(view) })} onClick={() => handle.setModel({ ...handle.getModel(), root: exchanged(handle.getModel().root, view) })} />
      )}
      <IconButton
        icon={EllipsisVertical}
        look="plain"
        label={t("Pane of {view}", { view: titleOf(view) })}
        onClick={(e) => open(e.currentTarget, t("Pane of {view}", { view: titleOf(view) }), deeds())}
      />
      {menu && <Menu place={menu} items={menu.items} close={() => show(undefined)} />}
    </>
  );
}

const renderToolbar = (tabset: TabsetNode<View>) => <Toolbar tabset={tabset} />;

/** The wiring keeps its layout. */
const hidden = ({ data }: TabNode<View>): HiddenTabBehavior => (data === "Wiring" ? "keep-mounted" : "unmount");

interface Props {
  handle: RefObject<Handle | null>;
  first: Tree;
  /** Is called with the panes as text whenever they have changed. */
  changed: (text: string) => void;
  content: (view: View) => ReactNode;
  emptiness: (view: View) => string;
}

export function Workspace({ handle, first, changed, content, emptiness }: Props) {
  const latest = useRef(emptiness);
  latest.current = emptiness;
  const model = useMemo(() => ({ version: 1 as const, root: first }), []);
  const drawn = useMemo(
    () => (
      <Panes<View>
        className="panes"
        workspaceRef={handle}
        defaultModel={model}
        onModelChanged={({ root }) => changed(written(root))}
        renderTab={renderTab}
        renderTabContent={renderContent}
        renderTabsetToolbar={renderToolbar}
        renderSeparator={renderSeparator}
        hiddenTabBehavior={hidden}
        lazyTabContent
        tabsetMinWidth="240px"
        tabsetMinHeight="120px"
      />
    ),
    [handle, model, changed],
  );
  return (
    <Content value={content}>
      <Emptiness value={latest}>{drawn}</Emptiness>
    </Content>
  );
}
