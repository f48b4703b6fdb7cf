"""Watch snow in a browser and play with it: `neve view SCENE` computes live, `neve view RUN` plays a run.

A *player* (live.py, recorded.py) has a thread of its own, keeps the latest state as a Snapshot (snapshot.py)
and takes commands (commands.py) from a queue. The *server* (server.py) encodes a snapshot once for all pages
(encode.py) and sends each page the latest one that it can take, so that nobody waits for anybody. The page
(page/) is plain JavaScript and WebGL 2 and comes from the installed package: no network is needed.
"""

from neve.viewer.show import ViewError, view, write_replay

__all__ = ["ViewError", "view", "write_replay"]
