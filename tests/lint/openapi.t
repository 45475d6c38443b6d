#!/usr/bin/perl
# openapi.yaml says what the tables say. Paths, methods and statuses are those of the routes; titles, texts,
# parameters, ranges, words and defaults those of the processes; members, types and bounds those of records, reports
# and other documents; media types those of the formats. And what a daemon answers is what is described.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Contract;
use Test::More;
use Vt;

my $contract = Contract->new;
my $doc = $contract->{doc};
my %operations = $contract->operations;
is $doc->{openapi}, '3.0.3', 'it is OpenAPI 3.0.3';
my @mappings = $contract->mappings;
my @dangling = map { "$_->[0]: $_->[1]{'$ref'}" }
    grep { !ref($_->[1]{'$ref'} // {}) && !$contract->resolved($_->[1]) } @mappings;
is_deeply \@dangling, [], 'every reference leads somewhere';

# --- routes ---------------------------------------------------------------------------------------

my (undef, undef, $printed) = Vt::run('--print-routes');
my %routes;
for my $line (split /\n/, $printed) {
    my ($method, $route, $scope, @codes) = split / /, $line;
    $routes{"$method $route"} = { map { $_ => 1 } @codes };
}
my @other_names = grep { !%{ $routes{$_} } } sort keys %routes;
delete @routes{@other_names};
ok $routes{ s{/$}{}r }, "$_ is another name of a route" for @other_names;
cmp_ok scalar(keys %routes), '>', 10, 'there is a route table';
is_deeply [sort keys %operations], [sort keys %routes], 'every route is documented, and no other';
for my $route (sort keys %routes) {
    my $operation = $operations{$route} // next;
    is_deeply [grep { /^\d+$/ } sort keys %{ $operation->{responses} }], [sort keys %{ $routes{$route} }],
        "$route: the same statuses";
    is_deeply [sort map { $_->{name} } $contract->parameters($operation, 'path')], [sort($route =~ /\{(\w+)\}/g)],
        "$route: the parameters of its path";
}

# --- processes ------------------------------------------------------------------------------------

my $daemon = Vt->start;
my @processes = map { $_->{id} } @{ json($daemon->get('/v1/processes'))->{processes} };
my %description = map { $_ => json($daemon->get("/v1/processes/$_")) } @processes;
is_deeply [sort map { m{^POST /v1/(\w+)$} ? $1 : () } keys %operations], [sort @processes],
    'every process that is offered has a path of its own';
my (%taken, %given);
my %of_a_job = map { $_ => 1 } qw(name input previous); # what any job takes beside the parameters of its process
for my $process (@processes) {
    my $described = $description{$process};
    my $operation = $operations{"POST /v1/$process"} // next;
    my %schemas = map { $_ => $described->{inputs}{$_}{schema} }
        grep { !is_cloud($described->{inputs}{$_}{schema}) } keys %{ $described->{inputs} };
    my %parameter = map { $_->{name} => $_ } $contract->parameters($operation, 'query');
    is $operation->{summary}, $described->{title}, "$process: its title";
    like squeezed($operation->{description}), qr/^\Q$described->{description}\E\.(?: |$)/,
        "$process: its description begins with its sentence";
    is_deeply [asked_for($operation)], [sort keys %schemas],
        "$process: its parameters are documented, each once, and no other";
    is_deeply plain($parameter{$_}{schema}), plain($schemas{$_}),
        "$process, $_: types, ranges, words and default" for grep { $parameter{$_} } sort keys %schemas;
    is_deeply [grep { begins($parameter{$_}, $described->{inputs}{$_}) } grep { $parameter{$_} } sort keys %schemas], [],
        "$process: descriptions of parameters begin with those of its table";
    $taken{$_} = 1 for keys %schemas;
    $given{$_} = $described->{outputs}{$_}{schema} for keys %{ $described->{outputs} };
}

my $execution = $operations{'POST /v1/processes/{processID}/execution'};
is_deeply [asked_for($execution)], [sort keys %taken], 'the execution of a process takes what any of them takes';
is_deeply [sort @{ $doc->{components}{parameters}{output}{schema}{enum} }], [sort keys %given],
    'every output has its name in the path';

# The names of the parameters of a process that an operation takes.
sub asked_for {
    my ($operation) = @_;
    return sort grep { !$of_a_job{$_} } map { $_->{name} } $contract->parameters($operation, 'query');
}

# A cloud is an input, not a parameter.
sub is_cloud { return $_[0]{oneOf} && ($_[0]{oneOf}[0]{contentEncoding} // '') eq 'binary' }

# The same with every number written in one way, truth as a word, and without units.
sub plain {
    my ($value) = @_;
    return { map { $_ => plain($value->{$_}) } grep { $_ ne 'x-unit' } keys %$value } if ref $value eq 'HASH';
    return [map { plain($_) } @$value] if ref $value eq 'ARRAY';
    return $value ? 'true' : 'false' if JSON::PP::is_bool($value);
    return defined $value && $value =~ /^[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?$/i ? $value + 0 : $value;
}

# --- the list of jobs, whose ranges stand in one file ----------------------------------------------

my $filter = Vt::slurp("$FindBin::Bin/../../server/api/handlers/jobs_filter.c");
my %constant = $filter =~ /\b(LIST_DEFAULT|LIST_MAX|SECONDS_MAX) = (\d+)/g;
my %asked = map { $_->{name} => $_->{schema} } $contract->parameters($operations{'GET /v1/jobs'}, 'query');
is_deeply plain($asked{limit}),
    { type => 'integer', minimum => 1, maximum => $constant{LIST_MAX}, default => $constant{LIST_DEFAULT} },
    'limit of a list: its range and its default';
is_deeply plain($asked{$_}), { type => 'integer', minimum => 0, maximum => $constant{SECONDS_MAX} }, "$_: its range"
    for qw(minDuration maxDuration);
my $strange = json($daemon->get('/v1/jobs?strange=1'))->{detail};
my ($names) = $strange =~ /want one of (.*?) +as +the name/;
is_deeply [sort keys %asked], [sort split /, | and /, $names // $strange], 'a list of jobs takes these parameters';
my ($statuses) = json($daemon->get('/v1/jobs?status=strange'))->{detail} =~ /want some of (.*)/;
is_deeply $asked{status}{items}{enum}, [split /, /, $statuses], 'the states that a list can be asked for';
is_deeply $contract->schema('statusInfo')->{properties}{status}{enum}, [split /, /, $statuses],
    'are those that a job has';
my ($stages) = Vt::slurp("$FindBin::Bin/../../server/store/row.h") =~ /#define VOR_STAGE_TABLE\(X\)((?:.*\\\n)*.*)/;
my @stages = $stages =~ /"(\w+)"/g;
is_deeply $contract->schema('progressEvent')->{allOf}[1]{properties}{stage}{enum}, \@stages, 'the stages of a job';
is_deeply [grep { defined } @{ $contract->schema('statusInfo')->{properties}{voronoid}{properties}{stage}{enum} }],
    \@stages, 'also in its statusInfo';

# --- media types ----------------------------------------------------------------------------------

my @clouds = map { $_->{contentMediaType} } @{ $given{cloud}{oneOf} };
my $is_cloud = join '|', map { quotemeta } @clouds, 'application/octet-stream';
my $result = $operations{'GET /v1/jobs/{jobID}/results/{output}'}{responses};
my $body = $contract->resolved($operations{'POST /v1/resample'}{requestBody})->{content};
my $answer = $contract->resolved($operations{'POST /v1/resample'}{responses}{200})->{content};
cmp_ok scalar @clouds, '>', 1, 'there are formats';
for my $case (['a body', $body], ['a result in the answer', $answer], ['a result', $result->{200}{content}],
    ['a part of a result', $result->{206}{content}]) {
    my ($name, $content) = @$case;
    is_deeply [grep { !$content->{$_} } @clouds], [], "$name may be in every format";
}
is_deeply [sort keys %{ $result->{206}{content} }], [sort keys %{ $result->{200}{content} }],
    'a part has the media type of the whole';
for my $mapping (@mappings) {
    my ($place, $content) = @$mapping;
    next unless $place =~ m{/content$};
    for my $type (grep { m{^(?:$is_cloud|\*/\*)$} || $place =~ m{/206/content$} } sort keys %$content) {
        my $schema = $content->{$type}{schema};
        is_deeply [@$schema{qw(type format)}], [qw(string binary)], "$place, $type: is binary";
    }
}
my $cloud = sphere_ply(300);
for my $type (grep { !m{^multipart/|json$} } sort keys %$body) {
    my $taken = $daemon->post('/v1/resample?points=50&iterations=2', $cloud, 'Content-Type' => $type =~ s/\*/any/gr);
    is $taken->{status}, 200, "a body may say that it is $type";
    is_deeply [$contract->faults_of(exchange('POST', '/v1/resample?points=50', $taken))], [], 'its answer is described';
}

# --- schemas --------------------------------------------------------------------------------------

my @empty = map { $_->[0] } grep {
    my $schema = $_->[1];
    !ref($schema->{type} // {}) && $schema->{type} eq 'object'
        && !%{ $schema->{properties} // {} } && !ref $schema->{additionalProperties} && !$schema->{allOf}
} @mappings;
is_deeply \@empty, [], 'no object is left undescribed';

# The documents of the processes and their record, as a process describes them, against the schemas here.
my %table = map { $_ => $given{$_} } grep { !is_cloud($given{$_}) } keys %given;
$table{record} = $description{resample}{'x-record'};
for my $name (sort keys %table) {
    my $schema = $contract->schema($name);
    cmp_ok scalar keys %{ $schema->{properties} }, '>', 5, "there is a schema of the $name";
    is_deeply [unlike_table($schema, $table{$name}, $name)], [], "the schema of the $name is that of its table";
}

# Where a schema is not that of the table: types, words, names, all of them required, null only where the table has
# it. A bound may be narrower here than in the table, which knows only that a count is not negative.
sub unlike_table {
    my ($schema, $table, $at) = @_;
    my $refers = $schema->{'$ref'};
    $schema = $contract->resolved($schema);
    my ($ours, $theirs) = ($schema->{properties} // {}, $table->{properties} // {});
    my %names = map { $_ => 1 } keys %$ours, keys %$theirs;
    my @faults = map { "$at: $_" } grep { said($schema, $_) ne said($table, $_) } qw(type enum required);
    push @faults, "$at: nullable" if !$table->{enum} && !$schema->{nullable} != !$table->{nullable};
    push @faults, "$at: minimum"
        if defined $table->{minimum} && !(defined $schema->{minimum} && $schema->{minimum} >= $table->{minimum});
    push @faults, "$at: description" if $at =~ /[.\[]/ && !$refers && begins($schema, $table);
    push @faults, unlike_table($schema->{items}, $table->{items}, "$at\[]") if $table->{items};
    return @faults unless %$theirs;
    return (@faults, map {
        $ours->{$_} && $theirs->{$_} ? unlike_table($ours->{$_}, $theirs->{$_}, "$at.$_") : "$at.$_"
    } sort keys %names);
}

# Whether a description does not begin with that of the table.
sub begins {
    my ($ours, $table) = map { squeezed($_->{description} // '') } @_;
    return $ours ne '' && index($ours, $table) != 0;
}

sub said {
    my ($schema, $what) = @_;
    my $value = $schema->{$what} // '';
    return ref $value ? join ' ', sort @$value : $value;
}

# --- answers --------------------------------------------------------------------------------------

sub exchange {
    my ($method, $target, $answer) = @_;
    return { method => $method, target => $target, body => $answer->{content}, %$answer{qw(status headers)} };
}

# Asks, and checks the answer's status, and that it is described.
sub asks {
    my ($method, $target, $status, %with) = @_;
    my $got = $daemon->request($method, $target, %with);
    my $with = join ' ', map { "$_: $with{headers}{$_}" } sort keys %{ $with{headers} // {} };
    is $got->{status}, $status, "$method $target $with is a $status";
    is_deeply [$contract->faults_of(exchange($method, $target, $got))], [], 'which is described';
    return $got;
}

my $id = $daemon->submit('points=50&iterations=2', $cloud);
is $daemon->finish($id)->{status}, 'successful', 'a job ends well';
asks('GET', $_, 200) for qw(/ /livez /readyz /version /openapi.yaml /openapi.json /docs /problems/queue-full /v1 /v1/processes),
    (map { "/v1/processes/$_" } @processes), "/v1/jobs/$id", '/v1/jobs?limit=1&status=successful,running',
    map { "/v1/jobs/$id/$_" } qw(results results/cloud results/report trace events);
is_deeply plain(json($daemon->get('/openapi.json'))), plain($contract->{doc}), 'the contract as JSON says the same';
asks('GET', $_, 404) for '/problems/none', '/v1/processes/none', '/v1/jobs/none', "/v1/jobs/$id/results/none";
asks('GET', '/v1/jobs?limit=0', 400);
for my $name (map { s/^GET //r } @other_names) {
    my ($whole, $other) = map { $daemon->get($_) } $name =~ s{/$}{}r, $name;
    is_deeply [@$other{qw(status content)}], [@$whole{qw(status content)}], "$name answers the same";
}
asks('GET', "/v1/jobs/$id/trace", 200, headers => { Accept => 'text/csv' });
asks('GET', "/v1/jobs/$id/events", 200, headers => { Accept => 'application/x-ndjson' });
asks('POST', "/v1/jobs/$id/stop", 409);
for my $output (qw(cloud report)) {
    my $whole = asks('HEAD', "/v1/jobs/$id/results/$output", 200);
    my $part = asks('GET', "/v1/jobs/$id/results/$output", 206, headers => { Range => 'bytes=0-9' });
    is $part->{headers}{'content-type'}, $whole->{headers}{'content-type'}, 'a part has the media type of the whole';
    asks('GET', "/v1/jobs/$id/results/$output", 416, headers => { Range => 'bytes=99999999-' });
    asks('GET', "/v1/jobs/$id/results/$output", 304, headers => { 'If-None-Match' => $whole->{headers}{etag} });
}
asks('POST', '/v1/resample?points=0', 400, content => $cloud);
asks('POST', '/v1/resample?points=50', 415, content => 'no cloud');
asks('POST', '/v1/resample?points=50', 406, content => $cloud, headers => { Accept => 'text/html' });
asks('POST', '/v1/inspect', 200, content => $cloud);
asks('POST', '/v1/inspect', 422, content => "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n");
my $accepted = asks('POST', '/v1/denoise', 201, content => $cloud, headers => { Prefer => 'respond-async' });
asks('DELETE', '/v1/jobs/' . json($accepted)->{jobID}, 200);

# What the schemas of events say is what comes, no less: a member that is described and never there is no fault above.
my @events = $daemon->events("/v1/jobs/$id/events", headers => { 'Last-Event-ID' => '1.1' })->all;
for my $case ([progress => 'progressEvent'], [end => 'endEvent']) {
    my ($name, $schema) = @$case;
    my ($event) = grep { $_->{event} eq $name } @events;
    my %members = $contract->members($contract->schema($schema));
    is_deeply [sort keys %{ json($event->{data}) }], [sort keys %members], "an event $name has all that is described";
    is_deeply [$contract->faults($contract->schema($schema), json($event->{data}))], [], 'as it is described';
}
my ($end) = map { json($_->{data}) } grep { $_->{event} eq 'end' } @events;
my @outputs = sort keys %{ $description{resample}{outputs} };
is_deeply [sort keys %{ $end->{outputs} }], \@outputs, 'an end has the outputs of the process';
is_deeply [sort keys %{ json($daemon->get("/v1/jobs/$id/results")) }], \@outputs, 'and so have the results';
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
