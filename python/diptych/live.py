"""A page that shows a simulation while it runs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LivePage:
    """Address of the page. Only browsers on this machine can open it. A notebook on this machine shows the page itself."""

    url: str

    def _repr_html_(self) -> str:
        frame = f'<iframe src="{self.url}" width="100%" height="640" style="border: 0"></iframe>'
        return f'{frame}<p><a href="{self.url}" target="_blank">{self.url}</a></p>'
