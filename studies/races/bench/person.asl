@go +!go : go <- !acts.
@once +!acts : once <- {command}.
@twice +!acts : twice <- {command}; {command}.
